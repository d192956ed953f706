"""Projection of a point onto the constraint along normals taken elsewhere."""

from typing import NamedTuple

import numpy as np

from sdaeverify import SDE, Array, HolonomicSDAE, Mask
from sdaeverify.numerics import apply_transposed, determinant, newton, norm, product_transposed

# Newton's last update moves the position by less than this part of it, so that its error is rounding: the square.
TOLERANCE = 1e-9


class Projected(NamedTuple):
    """A point of the constraint.

    Attributes
    ----------
    r : ndarray, shape (n, P)
        r = y + N^T kappa with g(r) = 0.
    Dg : ndarray, shape (m, n, P)
        Dg(r).
    kappa : ndarray, shape (m, P)
    A : ndarray, shape (m, m, P)
        Dg(r) N^T.
    found : ndarray of bool, shape (P,)
        Whether Newton's method converged from kappa = 0 to a root with det A > 0. With one constraint that is the
        root nearest to 0; with several, a far root may pass.
    iterations : ndarray of int, shape (P,)
    """

    r: Array
    Dg: Array
    kappa: Array
    A: Array
    found: Mask
    iterations: Array


def onto_constraint(problem: HolonomicSDAE | SDE, y: Array, normals: Array) -> Projected:
    """Solve g(y + N^T kappa) = 0 for the root nearest kappa = 0.

    Parameters
    ----------
    problem : HolonomicSDAE or SDE
        With a constraint g.
    y : ndarray, shape (n, P)
    normals : ndarray, shape (m, n, P)
        N, the rows of Dg(r_0) M^{-1} at another position r_0, or at y.

    Returns
    -------
    Projected
    """

    def linearised(kappa: Array) -> tuple[Array, Array]:
        x = y + apply_transposed(normals, kappa)
        return problem.constraint(x), product_transposed(problem.dg(x), normals)

    # kappa scales like 1/g, so that its tolerance has to come from that of the position.
    size = norm(y)
    tolerance = TOLERANCE * np.where(size > 0.0, size, 1.0) / np.sqrt(np.einsum("mnp,mnp->p", normals, normals))
    root = newton(linearised, np.zeros((len(normals), y.shape[-1])), tolerance)
    r = y + apply_transposed(normals, root.x)
    Dg = problem.dg(r)
    A = product_transposed(Dg, normals)
    return Projected(r, Dg, root.x, A, root.converged & (determinant(A) > 0.0), root.iterations)
