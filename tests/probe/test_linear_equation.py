"""Coefficients of linear equations, their second moments, and equations that are not linear."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from facade import GENERATOR, double_well, forced_ou, gbm, noncommuting, ou, pendulum, smat, svec
from probe.weak_cells import equation
from sdaeverify import SDE, Array, Problem
from sdaeverify.probing import linear_equation, why_not_linear_equation

EPS = np.finfo(float).eps


@pytest.mark.parametrize(
    ("problem", "rate"),
    [(gbm(0.5, 0.6), 1.36), (gbm(-10.0, 2.0), -16.0), (ou(2.0), -4.0), (ou(-0.5), 1.0)],
    ids=["growing", "stable", "additive", "additive and growing"],
)
def test_the_growth_rate_of_scalar_equations_is_2a_plus_b_squared(problem: SDE, rate: float) -> None:
    """Additive noise does not count for it."""
    assert linear_equation(problem).homogeneous.abscissa == pytest.approx(rate, rel=8 * EPS)


def test_the_growth_rate_of_a_system_is_that_of_its_kronecker_form() -> None:
    """The smaller matrix on symmetric matrices has the same leading eigenvalue."""
    expected = np.linalg.eigvals(GENERATOR).real.max()
    assert linear_equation(noncommuting()).homogeneous.abscissa == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    ("a", "b", "decays"),
    [(-1.0, 1.0, True), (-1.0, 2.0**0.5 + 1e-9, False), (-1.0, 2.0**0.5 - 1e-9, True), (-0.5, 1.0, None)],
)
def test_decay_is_certain_where_it_is_told(a: float, b: float, decays: bool | None) -> None:
    """A billionth beside the boundary 2a + b^2 = 0 either way, and not on it."""
    assert linear_equation(gbm(a, b)).homogeneous.decays() is decays


def test_second_moments_solve_their_differential_equation() -> None:
    """exp(t G) of the augmented equation agrees with an integration of P' = A P + P A^T + ... written out."""
    A, C, a, c = np.array([[-1.0, 2.0], [0.0, -0.5]]), np.array([[0.2, 0.1], [-0.3, 0.4]]), [0.3, -0.1], [0.5, 0.2]
    problem = equation(
        lambda t, x: A @ x + np.array(a)[:, None], lambda t, x: (C @ x + np.array(c)[:, None])[:, None], [1.0, -1.0]
    )
    linear, z = linear_equation(problem), np.array([1.0, -1.0, 1.0])
    P = smat(expm(linear.generator()) @ svec(np.outer(z, z)), 3)

    def slope(t: float, y: Array) -> Array:
        m, S = y[:2], y[2:].reshape(2, 2)
        B = C @ S @ C.T + np.outer(C @ m, c) + np.outer(c, C @ m) + np.outer(c, c)
        return np.concatenate([A @ m + a, (A @ S + S @ A.T + np.outer(a, m) + np.outer(m, a) + B).ravel()])

    start = np.concatenate([z[:2], np.outer(z[:2], z[:2]).ravel()])
    solved = solve_ivp(slope, (0.0, 1.0), start, rtol=1e-12, atol=1e-12, method="DOP853").y[:, -1]
    # The integration is what limits the comparison.
    assert np.concatenate([P[:2, 2], P[:2, :2].ravel()]) == pytest.approx(solved, abs=1e-10)
    assert not linear.starts_at_rest


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (double_well, "drift is not linear"),
        (forced_ou, "drift depends on time"),
        (pendulum, "not "),
        (lambda: equation(lambda t, x: -x, lambda t, x: 1e-8 * x[None] ** 2, [1.0]), "diffusion is not linear"),
        (lambda: equation(lambda t, x: -x, lambda t, x: (1.0 + t) * x[None], [1.0]), "diffusion depends on time"),
    ],
)
def test_what_is_not_linear_is_refused_with_a_reason(make: Callable[[], Problem], reason: str) -> None:
    """Curved coefficients, coefficients that depend on time, and constraints that are no planes."""
    assert reason in why_not_linear_equation(make())
