"""The affine problem: its law against moment equations, and the schemes against their closed recursions."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from facade import (
    ConstrainedEuler,
    PenalisedEuler,
    UniformExpansion,
    UniformlyAccurate,
    affine_constraint,
    affine_langevin,
    smat,
    step_moments,
    svec,
)
from sdaeverify import Array, Moment, Scheme
from sdaeverify.probing import OneStep
from sdaeverify_problems.affine._langevin import AffineLangevin

EPS = np.finfo(float).eps
SIZES = [(2, 1), (3, 1), (3, 2), (5, 3)]


def equation(eps: float, d: int, q: int) -> tuple[Array, Array, Array]:
    """Return A, a and B B^T of the problem's Ito equation dx = (A x + a) dt + B dW."""
    ito = affine_constraint(eps, d, q).ito()
    x = np.concatenate([np.zeros((d, 1)), np.eye(d)], axis=1)
    values, B = ito.drift(0.0, x), np.broadcast_to(ito.diffusion(0.0, x), (d, d, d + 1))[..., 0]
    return values[:, 1:] - values[:, :1], values[:, 0], B @ B.T


@pytest.mark.parametrize(("d", "q"), SIZES)
@pytest.mark.parametrize("eps", [0.0, 0.02, 0.25])
def test_moments_solve_their_equations(eps: float, d: int, q: int) -> None:
    """Expectations at time t follow from m' = A m + a, C' = A C + C A^T + B B^T, integrated numerically."""
    problem, t = affine_constraint(eps, d, q), 0.4
    A, a, noise = equation(eps, d, q)

    def rates(_: float, y: Array) -> Array:
        m, C = y[:d], y[d:].reshape(d, d)
        return np.concatenate([A @ m + a, (A @ C + C @ A.T + noise).ravel()])

    start = np.concatenate([problem.initial(1)[:, 0], np.zeros(d * d)])
    end = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    m, second = end[:d], end[d:].reshape(d, d) + np.outer(end[:d], end[:d])
    known = {truth.observable: truth.value(t) for truth in problem.truths if isinstance(truth, Moment)}

    assert known["x_1"] == pytest.approx(m[0], rel=1e-9)
    assert known["x_2"] == pytest.approx(m[1], rel=1e-9)
    assert known["x_1^2"] == pytest.approx(second[0, 0], rel=1e-9)
    assert known["x_1 x_2"] == pytest.approx(second[0, 1], rel=1e-9)


class Recursion(NamedTuple):
    """A step x+ = M x + r + N xi with independent xi of mean 0 and variance 1.

    Attributes
    ----------
    M, N : ndarray, shape (d, d)
    r : ndarray, shape (d,)
    """

    M: Array
    r: Array
    N: Array

    def moments(self, x: Array, steps: int) -> tuple[Array, Array]:
        """Return mean and covariance after some steps from x, shapes (d,) and (d, d)."""
        covariance = np.zeros_like(self.M)
        for _ in range(steps):
            x, covariance = self.M @ x + self.r, self.M @ covariance @ self.M.T + self.N @ self.N.T
        return x, covariance


def explicit_euler(given: AffineLangevin, h: float) -> Recursion:
    """Return the step (1.5), for eps > 0: M = Id - hK - (h/eps) P, N = sqrt(h) sigma Id."""
    one = np.eye(len(given.k))
    M = one - h * given.K - h / given.eps * given.P
    return Recursion(M, h * given.k + h / given.eps * given.p, np.sqrt(h) * given.sigma * one)


def constrained_euler(given: AffineLangevin, h: float) -> Recursion:
    """Return the steps (1.6) and (2.7), with Pi = Id - P: M = Pi (Id - hK), N = sqrt(h) sigma Pi."""
    one = np.eye(len(given.k))
    Pi = one - given.P
    return Recursion(Pi @ (one - h * given.K), h * Pi @ given.k + given.p, np.sqrt(h) * given.sigma * Pi)


def uniformly_accurate(given: AffineLangevin, h: float) -> Recursion:
    """Return the step (2.2), whatever theta is.

    With e = exp(-h/eps), M = Pi (Id - hK) + eP - eps (1 - e) PK and
    N = sqrt(h) sigma Pi + sigma sqrt((eps/2) (1 - e^2)) P.
    """
    M, r, N = constrained_euler(given, h)
    if given.eps == 0.0:
        return Recursion(M, r, N)
    e, gone = np.exp(-h / given.eps), -np.expm1(-h / given.eps)
    root = np.sqrt(-0.5 * given.eps * np.expm1(-2.0 * h / given.eps))
    P, slow = given.P, given.eps * gone
    return Recursion(
        M + e * P - slow * P @ given.K,
        r + slow * P @ given.k - e * given.p,
        N + given.sigma * root * P,
    )


SCHEMES: dict[str, tuple[Scheme, Callable[[AffineLangevin, float], Recursion]]] = {
    "explicit": (PenalisedEuler(), explicit_euler),
    "constrained": (ConstrainedEuler(), constrained_euler),
    "constrained, implicit direction": (ConstrainedEuler(direction="new"), constrained_euler),
    "theta = 0": (UniformlyAccurate(), uniformly_accurate),
    "theta = 1/2": (UniformlyAccurate(theta=0.5), uniformly_accurate),
    "theta = 1": (UniformlyAccurate(theta=1.0), uniformly_accurate),
    "three points": (UniformlyAccurate(xi="three-point"), uniformly_accurate),
    "expansion": (UniformExpansion(), uniformly_accurate),
}


def propagated(scheme: Scheme, eps: float, d: int, q: int) -> tuple[Array, Array]:
    """Return mean and covariance of a scheme after eight steps, by its operator on second moments."""
    problem = affine_constraint(eps, d, q)
    one_step = OneStep(scheme, problem.view(scheme.form))
    found = step_moments(one_step, problem.horizon / 8)
    z = np.append(problem.initial(1)[:, 0], 1.0)
    moments = smat(np.linalg.matrix_power(found.operator.dense(), 8) @ svec(np.outer(z, z)), d + 1)
    m = moments[:-1, -1]
    assert not found.failed
    return m, moments[:-1, :-1] - np.outer(m, m)


@pytest.mark.parametrize(("d", "q"), [(2, 1), (3, 2)])
@pytest.mark.parametrize("eps", [1e-6, 0.05, 0.25, 1e300])
@pytest.mark.parametrize("name", SCHEMES)
def test_schemes_have_the_moments_of_their_recursions(name: str, eps: float, d: int, q: int) -> None:
    """Mean and covariance after eight steps agree to rounding, found without sampling."""
    scheme, recursion = SCHEMES[name]
    given = affine_langevin(eps, d, q, 0.5, 0.7)
    m, C = propagated(scheme, eps, d, q)
    mean, covariance = recursion(given, 0.5 / 8).moments(affine_constraint(eps, d, q).initial(1)[:, 0], 8)

    # Rounding of the step, of the operator found from it and of eight powers, each relative to what is propagated.
    growth = max(1.0, np.linalg.norm(recursion(given, 0.5 / 8).M, 2) ** 16)
    assert np.abs(m - mean).max() <= 256 * EPS * growth
    assert np.abs(C - covariance).max() <= 256 * EPS * growth
