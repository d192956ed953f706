"""Projection of a position onto the constraint along the normals of another one."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Mask
from sdaeverify.numerics import apply_transposed, determinant, newton, norm

# Newton's last update moves the position by less than this, so that its error is of the size of the square: rounding.
TOLERANCE = 1e-9


class Projected(NamedTuple):
    """A point of the constraint.

    Attributes
    ----------
    r : ndarray, shape (n, P)
        r = y + M^{-1} grad g(r_0) kappa with g(r) = 0.
    kappa : ndarray, shape (m, P)
    A : ndarray, shape (m, m, P)
        Dg(r) M^{-1} grad g(r_0).
    found : ndarray of bool, shape (P,)
        Whether Newton's method converged from kappa = 0 to a root with det A > 0.
    """

    r: Array
    kappa: Array
    A: Array
    found: Mask


def onto_constraint(problem: HolonomicSDAE, y: Array, Dg: Array) -> Projected:
    """Solve g(y + M^{-1} grad g(r_0) kappa) = 0 for the root nearest kappa = 0.

    Parameters
    ----------
    problem : HolonomicSDAE
    y : ndarray, shape (n, P)
    Dg : ndarray, shape (m, n, P)
        Dg(r_0), whose rows are the normals.

    Returns
    -------
    Projected
    """

    def linearised(kappa: Array) -> tuple[Array, Array]:
        x = y + problem.inverse_mass(apply_transposed(Dg, kappa))
        return problem.constraint(x), problem.gram(problem.dg(x), Dg)

    # kappa scales like 1/g, so that its tolerance has to come from that of the position.
    normals = problem.inverse_mass(np.moveaxis(Dg, 1, 0))
    tolerance = TOLERANCE / norm(normals.reshape(-1, normals.shape[-1]))
    root = newton(linearised, np.zeros((len(Dg), y.shape[-1])), tolerance)
    r = y + problem.inverse_mass(apply_transposed(Dg, root.x))
    A = problem.gram(problem.dg(r), Dg)
    return Projected(r, root.x, A, root.converged & (determinant(A) > 0.0))
