"""The Euler step of penalised Langevin dynamics."""

import numpy as np
import pytest

from schemes.rough_constraints import langevin, points
from sdaeverify import SDE, Increment
from sdaeverify_problems.affine_constraint import affine_constraint, affine_langevin
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.penalised_euler import PenalisedEuler

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


@pytest.mark.parametrize("eps", [0.01, 0.3])
@pytest.mark.parametrize("q", [1, 3])
def test_a_step_on_a_flat_is_the_closed_recursion(q, eps):
    """A step is (Id - h K - (h/eps) P) x + ... to rounding, beside the flat as well."""
    affine, problem = affine_langevin(eps, 5, q, 0.5, 0.7), affine_constraint(eps, d=5, q=q)
    M, r, N = affine.explicit_euler(H)
    x = problem.initial(20) + 0.4 * np.random.default_rng(2).standard_normal((5, 20))
    noise = increments(x)

    result = PenalisedEuler().step(problem, x, 0.0, H, noise).state

    assert np.abs(result - (M @ x + r[:, None] + N @ noise.dW / np.sqrt(H))).max() < 32 * EPS * np.abs(x).max()


def test_the_limit_is_refused():
    """Without a penalty there is nothing to step along."""
    assert "eps = 0" in PenalisedEuler().refuses(langevin(1, 0.0))
    assert not PenalisedEuler().refuses(langevin(1, 1e-6))
