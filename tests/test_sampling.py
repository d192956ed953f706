"""Paths to look at."""

import numpy as np
import pytest

from facade import FIRST_BLOCK, Brownian, EulerMaruyama, gbm
from sdaeverify import SchemeError, UsageError, sample
from sdaeverify.studying import Source


def test_paths_are_those_of_a_run():
    """They are the recursion of the scheme on the noise of a run's first block."""
    paths = sample("euler-maruyama", "gbm", steps=32, paths=3, seed=5)

    x, source = [np.ones((1, 3))], Source(5, "gbm", 0, FIRST_BLOCK, 3)
    brownian = Brownian(source, 1, 1.0 / 8, 2, gbm().noise)
    for _, pieces in zip(range(8), brownian.pieces(), strict=False):
        for dW in (dW for level, noise in pieces if level == 2 for dW in noise.dW):
            x.append(x[-1] * (1.0 + 0.5 / 32 + 0.6 * dW))
    assert paths["x"] == pytest.approx(np.stack(x), rel=32 * 4 * np.finfo(float).eps)
    assert paths.times == pytest.approx(np.arange(33) / 32.0)
    assert (paths.scheme, paths.problem) == ("euler-maruyama", "gbm")


def test_objects_and_more_paths():
    """Objects do as labels do, and more paths keep the first ones."""
    few, many = sample("euler-maruyama", "gbm", paths=2), sample(EulerMaruyama(), gbm, paths=20)

    assert np.array_equal(few["x"], many["x"][:, :, :2])
    assert not np.array_equal(few["x"], sample("euler-maruyama", "gbm", paths=2, seed=6)["x"])


def test_components_of_mechanics():
    """Mechanics has positions on the constraint, velocities and multipliers; paths without root are told."""
    paths = sample("half-explicit-euler[truncation=none]", "pendulum[omega_0=40,horizon=1.0]", steps=8, paths=4)

    assert {name: part.shape for name, part in paths.components.items()} == {
        "r": (9, 2, 4), "v": (9, 2, 4), "mu": (9, 1, 4),
    }  # fmt: skip
    assert np.abs((paths["r"] ** 2).sum(axis=1) - 1.0).max() < 1e-14
    assert paths.without_root.all()
    assert not paths.lost.any()


def test_table_and_picture():
    """The table has a row for each time and a column for each path, the picture a line for each path."""
    pytest.importorskip("matplotlib")
    paths = sample("milstein", "gbm", steps=8, paths=3)

    frame = paths.frame()
    assert frame.shape == (9, 3)
    assert frame["x", 0, 2].to_numpy() == pytest.approx(paths["x"][:, 0, 2])
    ax = paths.plot()
    assert (len(ax.lines), ax.get_ylabel(), ax.get_title()) == (3, "x_1", "milstein on gbm")


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (("milstein", "gbm"), {"steps": 12}, "steps must be 8 times a power of 2, got 12"),
        (("milstein", "gbm"), {"steps": 4}, "steps must be 8 times a power of 2, got 4"),
        (("milstein", "gbm"), {"paths": 0}, "paths must be from 1 to 256, got 0"),
        (("milstein", "gbm"), {"paths": 257}, "paths must be from 1 to 256, got 257"),
        (("milstein", "gbm"), {"paths": 1.5}, "paths must be"),
        (("milstein", "gbm"), {"seed": -1}, "seed must be"),
        (("mil*,euler*", "gbm"), {}, "expected the label of one scheme"),
        (("milstein", "gbn"), {}, "unknown problem 'gbn'"),
    ],
)
def test_wrong_arguments(arguments, options, message):
    """What is wrong is one line."""
    with pytest.raises(UsageError, match=message) as error:
        sample(*arguments, **options)
    assert "\n" not in str(error.value)


def test_what_does_not_fit():
    """A scheme that cannot solve the problem, and a component that is not there, say so."""
    with pytest.raises(SchemeError, match="half-explicit-euler on gbm: needs a HolonomicSDAE"):
        sample("half-explicit-euler", "gbm")
    paths = sample("milstein", "gbm", steps=8, paths=1)
    with pytest.raises(UsageError, match="no component 'v'; there are x"):
        paths.plot("v")
    with pytest.raises(UsageError, match="index must be from 0 to 0 for x, got 1"):
        paths.plot("x", 1)
