"""Projection of a point onto the constraint along the normals at the new point."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ConstraintJacobian, HolonomicSDAE, Mask
from sdaeverify.numerics import norm

# The constraint counts as solved if |g| is within rounding of the position, or if the last relative update was below
# TOLERANCE, so that the error of g is its square and within rounding.
ROUNDING = float(np.finfo(float).eps)
TOLERANCE = 1e-9
# The normals converge linearly: tolerance of the part of r - y that is not along them, relative to the position.
NORMALS = 1e-11
MOST = 100
# Least s, because from the inner side of the constraint the distance may be nearly degenerate.
LEAST = 0.5


class Projected(NamedTuple):
    """A point of the constraint.

    Attributes
    ----------
    r : ndarray, shape (n, P)
        r = y + M^{-1} grad g(r) eta with g(r) = 0.
    J : ConstraintJacobian
        Dg(r).
    eta : ndarray, shape (m, P)
    found : ndarray of bool, shape (P,)
        Whether the iteration converged.
    iterations : ndarray of int, shape (P,)
    """

    r: Array
    J: ConstraintJacobian
    eta: Array
    found: Mask
    iterations: Array


def onto_constraint(problem: HolonomicSDAE, y: Array, tolerance: float = 0.0) -> Projected:
    """Solve F = r - y - M^{-1} grad g(r) eta = 0 and g(r) = 0 in (r, eta), from (y, 0).

    With H(eta) = sum_j eta_j Hess g_j, Newton's matrix is [[Id - M^{-1} H(eta), -M^{-1} grad g], [Dg, 0]]. Here
    Id - M^{-1} H(eta) is replaced by a scalar s for each path, so that only the Gram matrix has to be inverted:

        G_M(r) d_eta = Dg F - s g,    s d_r = M^{-1} grad g d_eta - F.

    The first update is Newton's: eta = 0 and s = 1. After each update, s is the mean of Id - M^{-1} H(eta) along it,
    <d_r, (Id - M^{-1} H) d_r>/|d_r|^2, which equals the old s plus <d_r, F>/|d_r|^2 (Barzilai & Borwein 1988). For
    every s, Dg d_r = -g: g converges quadratically, the normals linearly. Newton's method needs fewer updates, but
    each of them solves n + m equations instead of m.

    A root is a point whose distance from y, in the norm of M, is stationary. Because s > 0, the iteration is
    attracted only by roots where this distance is a minimum.

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
    size, J = norm(y), problem.linearised(y)
    size, s = np.where(size > 0.0, size, 1.0), np.ones_like(size)
    small, along = max(ROUNDING, tolerance) * J.size() * size, max(NORMALS, tolerance) * size
    found, active, iterations = np.zeros(len(s), dtype=bool), np.ones(len(s), dtype=bool), np.zeros_like(s)
    r, eta = y, -J.gram(J).solve(problem.constraint(y))
    move = problem.push(J, eta)
    for _ in range(MOST):
        r = _update(active, r + move, r)
        iterations += active
        J, g, moved = problem.linearised(r), problem.constraint(r), norm(move)
        F = r - y - problem.push(J, eta)
        near = (moved <= TOLERANCE * size) | (norm(g) <= small)
        found |= active & near & (norm(F) <= along)
        # A path that is no longer finite does not prolong the iteration.
        active &= ~found & np.isfinite(moved)
        if not active.any():
            break
        s = np.maximum(LEAST, s + np.einsum("np,np->p", move, F) / np.where(moved > 0.0, moved**2, 1.0))
        change = J.gram(J).solve(J.times(F) - s * g)
        move = (problem.push(J, change) - F) / s
        eta = _update(active, eta + change, eta)
    return Projected(r, J, eta, found, iterations)


def _update(active: Mask, new: Array, old: Array) -> Array:
    return new if active.all() else np.where(active, new, old)
