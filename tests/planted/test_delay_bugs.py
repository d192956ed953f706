"""Planted bugs of delay equations change the step where they are said to, and nowhere else."""

import numpy as np
import pytest

from schemes.delay_cells import MESHES, H, T, given, nonlinear
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Scheme, flatten
from sdaeverify_planted.delay_lag import READINGS, AnticipatingNoise, WrongLag
from sdaeverify_planted.delay_theta import KeptAlgebraic, OldLagAlgebraic, SingleIteration
from sdaeverify_schemes.stochastic_theta import StochasticTheta

# Meshes on which a wrong reading is the right one.
SAME = {
    "right": set(MESHES),
    "ahead": {"tau = 0"},
    "present": {"tau = 0"},
    "known": set(MESHES) - {"h > tau", "tau = 0"},
    "swapped": set(MESHES) - {"h > tau"},
}


def moved(scheme: Scheme, mesh: str) -> Array:
    problem = nonlinear(MESHES[mesh] * H)
    state, noise = given(problem, H)
    return flatten(scheme.prepare(problem, H)(state, T, noise).state)


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("mesh", MESHES)
def test_a_wrong_lag_differs_where_it_is_wrong(reading: str, mesh: str) -> None:
    """Each reading differs from the right step on its meshes, and is that step on the others."""
    difference = np.abs(moved(WrongLag(0.5, reading), mesh) - moved(StochasticTheta(0.5), mesh)).max(axis=0)

    if mesh in SAME.get(reading, set()):
        assert difference.max() <= 1e-13
    else:
        assert difference.min() > 1e-4


@pytest.mark.parametrize("scheme", [KeptAlgebraic(), OldLagAlgebraic(), SingleIteration(), AnticipatingNoise()])
def test_other_bugs_are_seen_in_one_step(scheme: Scheme) -> None:
    """A wrong y, or noise with the new lag, changes the step by far more than rounding."""
    difference = moved(scheme, "m = 3, delta") - moved(StochasticTheta(scheme.theta), "m = 3, delta")

    assert np.abs(difference).max(axis=0).min() > 1e-6
