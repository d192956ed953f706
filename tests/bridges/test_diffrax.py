"""Solvers of diffrax as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import PATHS, H, drawn
from facade import angle_pendulum, gbm, ou
from sdaeverify import SDE, Increment
from sdaeverify_bridges.diffrax import ORDERS, Diffrax, DiffraxLangevin

pytest.importorskip("diffrax", reason="needs the extra: pip install .[diffrax]")
pytestmark = pytest.mark.filterwarnings("default:os.fork:RuntimeWarning")


class Calls:
    """How often a formula was run."""

    number = 0


@pytest.mark.parametrize("solver", ORDERS)
def test_every_solver_is_compiled_once(solver):
    """A second step of another size, on a problem built anew and on fewer paths runs none of its formulas."""
    calls = Calls()

    def counted(rate):
        def drift(t, x):
            calls.number += 1
            return -rate * x

        return SDE(
            drift=drift,
            diffusion=lambda t, x: np.full((1, 1, 1), 0.5),
            start=[1.0],
            noise_dim=1,
            horizon=1.0,
            traits=frozenset({"additive-noise"}),
            source="a test",
        )

    one, other = counted(0.75), counted(0.75)
    scheme, noise = Diffrax(solver), drawn(one, H, PATHS)
    scheme.prepare(one, H)(scheme.start(one, PATHS, H), 0.0, noise)
    start = scheme.start(other, 3, H)
    traced, calls.number = calls.number, 0
    fewer = Increment(noise.dW[:, :3], noise.H[:, :3])
    scheme.prepare(other, 0.5 * H)(start, 0.5, fewer)

    assert traced
    assert not calls.number


def test_langevin_solver_without_noise_is_the_motion():
    """With a force that vanishes, ALIGN makes the exact step of dv = -gamma v dt + sigma dW, given dW = H = 0."""
    problem = replace(angle_pendulum(c=0.0), momentum=[2.0], truths=())
    nothing = Increment(np.zeros((1, 1)), np.zeros((1, 1)))
    decay = np.exp(-0.5 * H)

    found = DiffraxLangevin().step(problem, problem.initial(1), 0.0, H, nothing).state
    np.testing.assert_allclose(found[:, 0], [1.0 + 2.0 * (1.0 - decay) / 0.5, 2.0 * decay], rtol=1e-14)


def test_solvers_of_additive_noise_refuse_others():
    """What the documentation leaves out is refused, and the reason says why."""
    assert Diffrax("ShARK").refuses(gbm()) == "the noise is not declared additive"
    assert not Diffrax("ShARK").refuses(ou())
