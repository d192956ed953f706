"""Algorithms of sdeint as schemes; skipped where it is not installed."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

import sdaeverify
from bridges.equations import curved, drawn
from facade import EulerMaruyama, Heun, angle_pendulum, gbm, hyperbolic_pair, noncommuting
from sdaeverify import SDE, Increment, ParameterError
from sdaeverify_bridges.kit import Coefficients, stratonovich_drift
from sdaeverify_bridges.sdeint import ORDERS, SDEInt

H, PATHS = 0.125, 7


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where sdeint is not installed."""
    return pytest.importorskip("sdeint", reason="sdeint is not installed; pip install '.[sdeint]'")


@pytest.mark.parametrize(
    ("algorithm", "ours", "family"),
    [
        ("itoEuler", EulerMaruyama(), gbm),
        ("itoEuler", EulerMaruyama(), noncommuting),
        ("itoEuler", EulerMaruyama(), angle_pendulum),
        ("stratHeun", Heun(), curved),
        ("stratHeun", Heun(), noncommuting),
    ],
)
def test_our_schemes_agree_to_rounding(algorithm, ours, family):
    """On the same noise sdeint makes the step that ours makes, all paths at once."""
    problem = family().view(SDE)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (scheme.step(problem, x, 0.5, H, noise).state for scheme in (SDEInt(algorithm), ours))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * np.finfo(float).eps * np.abs(expected).max())


@pytest.mark.parametrize("algorithm", ["itoSRI2", "stratSRS2"])
@pytest.mark.parametrize("family", [curved, hyperbolic_pair, noncommuting], ids=lambda family: family.__name__)
def test_paths_at_once_are_paths_one_by_one(algorithm, family):
    """Rows of paths in the place of numbers give what sdeint gives for one path, with numbers."""
    import sdeint  # noqa: PLC0415 - it may be missing

    problem, scheme = family(), SDEInt(algorithm, areas=True)
    x = problem.initial(PATHS) + 0.1 * np.arange(PATHS)
    l = problem.noise_dim
    noise = drawn(problem, H, PATHS)._replace(A=np.full((l * (l - 1) // 2, PATHS), 0.1))
    found = scheme.step(problem, x, 0.5, H, noise).state

    name, shift = ("J", 0.5 * H) if scheme.stratonovich else ("I", 0.0)
    integrals = noise.double_integrals(H) + shift * np.eye(l)[..., None]
    equation = Coefficients(problem, np, scheme.stratonovich)

    def drift(y, t):
        return equation.drift(t, y[:, None])[:, 0]

    def diffusion(y, t):
        return equation.diffusion(t, y[:, None])[..., 0]

    for path in range(PATHS):
        given = {"dW": noise.dW[None, :, path], name: integrals[None, ..., path]}
        alone = getattr(sdeint, algorithm)(drift, diffusion, x[:, path], np.array([0.5, 0.5 + H]), **given)[-1]
        np.testing.assert_allclose(found[:, path], alone, rtol=1e-13)


def test_areas_that_are_not_there_are_refused():
    """Without areas an algorithm is for noise that needs none; with them it asks for them."""
    assert SDEInt("itoSRI2").refuses(noncommuting())
    assert not SDEInt("itoSRI2").refuses(hyperbolic_pair())
    assert SDEInt("itoSRI2", areas=True).noise == {"dW", "A"}


def test_one_brownian_motion_needs_no_areas():
    """With and without them the step is the same."""
    problem, noise = curved(), Increment(np.array([[0.3, -0.2]]), None)
    x = problem.initial(2)

    one, other = (SDEInt("itoSRI2", areas=areas).step(problem, x, 0.0, H, noise).state for areas in (False, True))
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("stratKP2iS",), f"must be one of {', '.join(ORDERS)}"),
        (("itoEuler", True), "areas are for itoSRI2 and strat"),
    ],
)
def test_algorithm_is_checked(arguments, message):
    """An algorithm that cannot be given a step at a time is refused."""
    with pytest.raises(ParameterError, match=message):
        SDEInt(*arguments)


class Louder(SDEInt):
    """dW is given to the algorithm with a factor of 1.1."""

    name: ClassVar[str] = "sdeint-louder"

    def compiled(self, problem):
        right = super().compiled(problem)
        return lambda x, t, h, dW: right(x, t, h, 1.1 * dW)


class Mistaken(SDEInt):
    """An algorithm for Ito's equation is given the drift of the Stratonovich equation."""

    name: ClassVar[str] = "sdeint-mistaken"

    def compiled(self, problem):
        return super().compiled(replace(problem, drift=lambda t, x: stratonovich_drift(problem, t, x)))


@pytest.mark.parametrize("wrong", [Louder("itoSRI2"), Mistaken("itoSRI2")], ids=["scaled noise", "wrong calculus"])
def test_wrong_bridge_is_refuted(wrong):
    """A bridge that hands over the wrong noise or the wrong calculus is refuted, not the library's algorithm."""
    found = sdaeverify.verify([wrong, SDEInt(wrong.algorithm)], [gbm], "strong", paths=512, levels=4, jobs=1).verdicts

    by_scheme = found.groupby("scheme")["verdict"].agg(set)
    assert by_scheme[wrong.label] == {"refuted"}
    assert "refuted" not in by_scheme[SDEInt(wrong.algorithm).label]
