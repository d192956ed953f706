"""The affine problem: its law against moment equations, and the steps of schemes against their closed forms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from facade import (
    ConstrainedEuler,
    PenalisedEuler,
    UniformExpansion,
    UniformlyAccurate,
    affine_constraint,
    affine_langevin,
)
from problems.linear_moments import moments_at
from sdaeverify import Array, Increment, Moment, Scheme
from sdaeverify_problems.affine._langevin import AffineLangevin

EPS = np.finfo(float).eps


@pytest.mark.parametrize(("d", "q"), [(2, 1), (3, 1), (3, 2), (5, 3)])
@pytest.mark.parametrize("eps", [0.0, 0.02, 0.25])
def test_moments_solve_their_equations(eps: float, d: int, q: int) -> None:
    """Expectations at a time follow from the problem's own Ito equation dx = (A x + a) dt + B dW."""
    problem = affine_constraint(eps, d, q)
    ito = problem.ito()
    x = np.concatenate([np.zeros((d, 1)), np.eye(d)], axis=1)
    values, B = ito.drift(0.0, x), np.broadcast_to(ito.diffusion(0.0, x), (d, d, d + 1))[..., 0]
    m, C = moments_at(values[:, 1:] - values[:, :1], values[:, 0], B @ B.T, problem.initial(1)[:, 0], 0.4)
    known = {truth.observable: truth.value(0.4) for truth in problem.truths if isinstance(truth, Moment)}

    second = C + np.outer(m, m)
    expected = {"x_1": m[0], "x_2": m[1], "x_1^2": second[0, 0], "x_1 x_2": second[0, 1]}
    assert {name: known[name] for name in expected} == pytest.approx(expected, rel=1e-9)


class Affine(NamedTuple):
    """A step x+ = M x + r + N xi of xi = dW/sqrt(h), shapes (d, d), (d,) and (d, d)."""

    M: Array
    r: Array
    N: Array


def explicit_euler(given: AffineLangevin, h: float) -> Affine:
    """Return the step (1.5), for eps > 0: M = Id - hK - (h/eps) P, N = sqrt(h) sigma Id."""
    one = np.eye(len(given.k))
    M = one - h * given.K - h / given.eps * given.P
    return Affine(M, h * given.k + h / given.eps * given.p, np.sqrt(h) * given.sigma * one)


def constrained_euler(given: AffineLangevin, h: float) -> Affine:
    """Return the steps (1.6) and (2.7), with Pi = Id - P: M = Pi (Id - hK), N = sqrt(h) sigma Pi."""
    one = np.eye(len(given.k))
    Pi = one - given.P
    return Affine(Pi @ (one - h * given.K), h * Pi @ given.k + given.p, np.sqrt(h) * given.sigma * Pi)


def uniformly_accurate(given: AffineLangevin, h: float) -> Affine:
    """Return the step (2.2), whatever theta is.

    With e = exp(-h/eps), M = Pi (Id - hK) + eP - eps (1 - e) PK and
    N = sqrt(h) sigma Pi + sigma sqrt((eps/2) (1 - e^2)) P.
    """
    (M, r, N), P, eps = constrained_euler(given, h), given.P, given.eps
    e, slow = np.exp(-h / eps), -eps * np.expm1(-h / eps)
    root = np.sqrt(-0.5 * eps * np.expm1(-2.0 * h / eps))
    return Affine(M + e * P - slow * P @ given.K, r + slow * P @ given.k - e * given.p, N + given.sigma * root * P)


SCHEMES: dict[str, tuple[Scheme, Callable[[AffineLangevin, float], Affine]]] = {
    "explicit": (PenalisedEuler(), explicit_euler),
    "constrained": (ConstrainedEuler(), constrained_euler),
    "constrained, implicit direction": (ConstrainedEuler(direction="new"), constrained_euler),
    **{f"theta = {theta}": (UniformlyAccurate(theta=theta), uniformly_accurate) for theta in (0.0, 0.5, 1.0)},
    "expansion": (UniformExpansion(), uniformly_accurate),
}


@pytest.mark.parametrize(("d", "q"), [(2, 1), (3, 2)])
@pytest.mark.parametrize("eps", [1e-6, 0.05, 0.25, 1e300])
@pytest.mark.parametrize("name", SCHEMES)
def test_steps_are_their_closed_forms(name: str, eps: float, d: int, q: int) -> None:
    """From points of the problem's own manifold and beside it, to rounding of what is multiplied."""
    (scheme, closed), h, problem = SCHEMES[name], 1 / 16, affine_constraint(eps, d, q)
    given = affine_langevin(eps, d, q, 0.5, 0.7)
    rng = np.random.default_rng(1)
    x, xi = problem.initial(5) + 0.1 * rng.standard_normal((d, 5)), rng.standard_normal((d, 5))
    M, r, N = closed(given, h)

    step = scheme.prepare(problem.view(scheme.form), h)(x, 0.0, Increment(np.sqrt(h) * xi, None))

    error = 256 * EPS * max(1.0, np.linalg.norm(M, 2))
    assert np.abs(step.state - M @ x - r[:, None] - N @ xi).max() <= error
