"""The Euler step of penalised Langevin dynamics."""

import numpy as np
import pytest

from facade import EulerMaruyama, PenalisedEuler
from schemes.rough_constraints import langevin, points
from sdaeverify import SDE, Increment

EPS = float(np.finfo(float).eps)
H = 0.02


def increments(x):
    return Increment(np.sqrt(H) * np.random.default_rng(3).standard_normal(x.shape), None)


@pytest.mark.parametrize("q", [1, 2, 3])
def test_a_step_is_that_of_euler_maruyama_for_the_penalised_equation(q):
    """It is Euler-Maruyama for (1.4), which the form offers to schemes for SDEs."""
    problem, x = langevin(q, 0.1), points(q, 0.2)

    result = PenalisedEuler().step(problem, x, 0.0, H, increments(x)).state

    expected = EulerMaruyama().step(problem.view(SDE), x, 0.0, H, increments(x)).state
    assert np.abs(result - expected).max() < 16 * EPS


def test_the_limit_is_refused():
    """Without a penalty there is nothing to step along."""
    assert "eps = 0" in PenalisedEuler().refuses(langevin(1, 0.0))
    assert not PenalisedEuler().refuses(langevin(1, 1e-6))
