"""Iteration and tolerance of the projection of a position along the normals at the new point."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE, ParameterError
from sdaeverify.numerics import directional, norm, solve

from ._new_normals import MOST, ROUNDING, TOLERANCE, Projected, onto_constraint

SOLVERS = ("gram", "newton")


class Projection(NamedTuple):
    """An iteration and its tolerance.

    Attributes
    ----------
    solver : str
        ``gram``, which inverts only Gram matrices, see `onto_constraint`, or ``newton``.
    tolerance : float
        Tolerance of both equations relative to the position; 0 for rounding.
    """

    solver: str
    tolerance: float

    @property
    def counter(self) -> str:
        """Name under which iterations are reported, which differs for Newton's method."""
        return "newton_iterations" if self.solver == "newton" else "projection_iterations"

    def __call__(self, problem: HolonomicSDAE, y: Array) -> Projected:
        """Return the point of the constraint, from (y, 0)."""
        if self.solver == "newton":
            return by_newton(problem, y, self.tolerance)
        return onto_constraint(problem, y, self.tolerance)


def check_projection(solver: str, tolerance: float) -> None:
    """Raise ParameterError for an unknown solver or an invalid tolerance."""
    if solver not in SOLVERS:
        raise ParameterError(f"solver must be gram or newton, got {solver!r}")
    if not 0.0 <= tolerance < 1.0:
        raise ParameterError(f"tolerance must be at least 0 and below 1, got {tolerance!r}")


def by_newton(problem: HolonomicSDAE, y: Array, tolerance: float) -> Projected:
    """Solve F = r - y - M^{-1} grad g(r) eta = 0 and g(r) = 0 in (r, eta) by Newton's method, from (y, 0).

    The matrix is [[Id - M^{-1} H(eta), -M^{-1} grad g], [Dg, 0]] with H(eta) = sum_j eta_j Hess g_j, as in Lindner et
    al. (2018), section 4.1. It is dense, with n + m equations per path and iteration.

    Parameters
    ----------
    problem : HolonomicSDAE
    y : ndarray, shape (n, P)
    tolerance : float
        Tolerance of F relative to |y|, and of g relative to its cancelling terms; 0 for rounding.

    Returns
    -------
    Projected
    """
    r, eta, J = y, np.zeros_like(problem.constraint(y)), problem.linearised(y)
    size = norm(y)
    size, close = np.where(size > 0.0, size, 1.0), max(tolerance, 4.0 * ROUNDING)
    F, g, scale = np.zeros_like(y), problem.constraint(y), J.size() * size
    found, active, iterations = np.zeros(len(size), dtype=bool), np.ones(len(size), dtype=bool), np.zeros_like(size)
    for _ in range(MOST):
        change = solve(_matrix(problem, r, eta), -np.concatenate([F, g]))
        r, eta = (np.where(active, old + part, old) for old, part in ((r, change[: len(y)]), (eta, change[len(y) :])))
        iterations += active
        J, g, moved = problem.linearised(r), problem.constraint(r), norm(change[: len(y)])
        F = r - y - problem.push(J, eta)
        small = (norm(F) <= close * size) & (norm(g) <= close * scale)
        found |= active & (small | (moved <= TOLERANCE * size))
        active &= ~found & np.isfinite(moved)
        if not active.any():
            break
    return Projected(r, J, eta, found, iterations)


def _matrix(problem: HolonomicSDAE, r: Array, eta: Array) -> Array:
    """Return Newton's matrix, shape (n + m, n + m, P)."""
    n, m, paths = len(r), len(eta), r.shape[1]
    Dg, A = problem.dg(r), np.zeros((n + m, n + m, paths))
    for k, unit in enumerate(np.eye(n)):
        turned = directional(problem.dg, r, np.broadcast_to(unit[:, None], r.shape))
        A[:n, k] = unit[:, None] - problem.inverse_mass(np.einsum("jp,jnp->np", eta, turned))
    for j in range(m):
        A[:n, n + j] = -problem.inverse_mass(np.broadcast_to(Dg[j], r.shape))
    A[n:, :n] = Dg
    return A
