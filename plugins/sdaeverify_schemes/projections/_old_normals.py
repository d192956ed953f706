"""Projection of a point onto the constraint along normals at another point."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from sdaeverify import SDE, Array, ConstraintJacobian, Gram, HolonomicSDAE, Mask
from sdaeverify.numerics import newton, norm, update_tolerance


class Projected(NamedTuple):
    """A point of the constraint.

    Attributes
    ----------
    r : ndarray, shape (n, P)
        r = y + M^{-1} grad g(r_0) kappa with g(r) = 0.
    J : ConstraintJacobian
        Dg(r).
    kappa : ndarray, shape (m, P)
    A : Gram
        Dg(r) M^{-1} grad g(r_0).
    found : ndarray of bool, shape (P,)
        Whether Newton's method converged from kappa = 0 to a root with det A > 0. With one constraint this is the
        root nearest to 0; with several constraints, a far root may be accepted.
    iterations : ndarray of int, shape (P,)
    """

    r: Array
    J: ConstraintJacobian
    kappa: Array
    A: Gram
    found: Mask
    iterations: Array


def onto_constraint(problem: HolonomicSDAE | SDE, y: Array, old: ConstraintJacobian) -> Projected:
    """Solve g(y + M^{-1} grad g(r_0) kappa) = 0 for the root nearest kappa = 0.

    Parameters
    ----------
    problem : HolonomicSDAE or SDE
        Problem with a constraint g; M is the identity for an SDE.
    y : ndarray, shape (n, P)
    old : ConstraintJacobian
        Linearisation at another position r_0, or at y.

    Returns
    -------
    Projected
    """
    none = np.zeros_like(old.times(y))
    one = len(none) == 1
    length = norm(problem.push(old, none + 1.0)) if one else None

    def gram(x: Array) -> Gram:
        return problem.linearised(x).gram(old)

    def linearised(kappa: Array) -> tuple[Array, Gram | Callable[[], Gram]]:
        x = y + problem.push(old, kappa)
        # With one constraint, recomputing the matrix is cheaper than testing whether the old one suffices.
        return problem.constraint(x), gram(x) if one else partial(gram, x)

    def moved(kappa: Array) -> Array:
        return norm(problem.push(old, kappa)) if length is None else length * np.abs(kappa[0])

    # kappa scales like 1/g, so the size of an update is measured in positions.
    root = newton(linearised, none, update_tolerance(norm(y)), solver=lambda A, value: A.solve(value), size=moved)
    r = y + problem.push(old, root.x)
    J = problem.linearised(r)
    A = J.gram(old)
    return Projected(r, J, root.x, A, root.converged & A.positive(), root.iterations)
