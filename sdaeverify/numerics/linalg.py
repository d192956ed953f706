"""Small linear algebra on every path at once, paths last."""

import numpy as np

from ..arrays import Array, Mask


def apply(A: Array, x: Array) -> Array:
    """Return A x on every path.

    Parameters
    ----------
    A : ndarray, shape (m, n, P) or (m, n, 1)
    x : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (m, P)
    """
    return np.einsum("mnp,np->mp", A, x)


def apply_transposed(A: Array, y: Array) -> Array:
    """Return A^T y on every path; shapes (m, n, P), (m, P) -> (n, P)."""
    return np.einsum("mnp,mp->np", A, y)


def product_transposed(A: Array, B: Array) -> Array:
    """Return A B^T on every path; shapes (m, n, P), (k, n, P) -> (m, k, P)."""
    return np.einsum("mnp,knp->mkp", A, B)


def solve(A: Array, b: Array) -> Array:
    """Solve A x = b on every path; a singular matrix gives non-finite numbers on its path only.

    Parameters
    ----------
    A : ndarray, shape (m, m, P)
    b : ndarray, shape (m, P)

    Returns
    -------
    ndarray, shape (m, P)
    """
    if len(b) == 1:
        return b / A[0]
    if len(b) == 2:
        return np.stack([A[1, 1] * b[0] - A[0, 1] * b[1], A[0, 0] * b[1] - A[1, 0] * b[0]]) / determinant(A)
    matrices = np.ascontiguousarray(np.moveaxis(A, -1, 0))
    try:
        x = np.linalg.solve(matrices, b.T[..., None])
    except np.linalg.LinAlgError:
        singular = np.linalg.det(matrices) == 0.0
        x = np.linalg.solve(np.where(singular[:, None, None], np.nan, matrices), b.T[..., None])
    return x[..., 0].T


def determinant(A: Array) -> Array:
    """Return det A on every path; shape (m, m, P) -> (P,)."""
    if len(A) == 1:
        return A[0, 0]
    if len(A) == 2:
        return A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    return np.linalg.det(np.moveaxis(A, -1, 0))


def norm(x: Array) -> Array:
    """Return the Euclidean norm of every path; shape (n, P) -> (P,)."""
    return np.sqrt(np.einsum("np,np->p", x, x))


def all_finite(x: Array) -> Mask:
    """Tell which paths are finite in every component; shape (n, P) -> (P,)."""
    # The sum of a row's components is finite only if all of them are (or if they overflow, which is as bad).
    return np.isfinite(x.sum(axis=0))
