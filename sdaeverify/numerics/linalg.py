"""Small linear algebra on every path at once, paths last."""

import numpy as np

from ..arrays import Array, Mask


def apply(A: Array, x: Array) -> Array:
    """Return A x on every path.

    Parameters
    ----------
    A : ndarray, shape (m, n, P) or (m, n, 1)
    x : ndarray, shape (n, P) or (n, k, P)

    Returns
    -------
    ndarray, shape (m, P) or (m, k, P)
    """
    if A.shape[1] == 1 and x.ndim == 2:
        # One column is one product: a third of the time of the general sum.
        return np.asarray(A[:, 0] * x[0])
    product: Array = np.einsum("mnp,n...p->m...p", A, x)
    return product


def apply_transposed(A: Array, y: Array) -> Array:
    """Return A^T y on every path; shapes (m, n, P), (m, ..., P) -> (n, ..., P)."""
    product: Array = np.einsum("mnp,m...p->n...p", A, y)
    return product


def product_transposed(A: Array, B: Array) -> Array:
    """Return A B^T on every path; shapes (m, n, P), (k, n, P) -> (m, k, P)."""
    product: Array = np.einsum("mnp,knp->mkp", A, B)
    return product


def solve(A: Array, b: Array) -> Array:
    """Solve A x = b on every path; a singular matrix gives non-finite numbers on its path only.

    Parameters
    ----------
    A : ndarray, shape (m, m, P)
    b : ndarray, shape (m, P) or (m, k, P)

    Returns
    -------
    ndarray, shape of b
    """
    if len(b) > 2:
        return _lapack_solve(A, b)
    x: Array = b / A[0] if len(b) == 1 else _adjugate_times(A, b) / determinant(A)
    return x


def determinant(A: Array) -> Array:
    """Return det A on every path; shape (m, m, P) -> (P,)."""
    if len(A) > 2:
        return np.asarray(np.linalg.det(np.moveaxis(A, -1, 0)))
    value: Array = A[0, 0] if len(A) == 1 else A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    return value


def largest(x: Array) -> Array:
    """Return the largest absolute component of every path; shape (n, P) -> (P,)."""
    sizes: Array = np.abs(x)
    return sizes[0] if len(x) == 1 else np.asarray(sizes.max(axis=0))


def norm(x: Array) -> Array:
    """Return the Euclidean norm of every path; shape (n, P) -> (P,)."""
    length: Array = np.sqrt(np.einsum("np,np->p", x, x))
    return length


def all_finite(x: Array) -> Mask:
    """Tell which paths are finite in every component; shape (n, P) -> (P,)."""
    # A path's sum is finite only if all of its components are (or if it overflows, which is as bad).
    finite: Mask = np.isfinite(x.sum(axis=0))
    return finite


def _adjugate_times(A: Array, b: Array) -> Array:
    return np.stack([A[1, 1] * b[0] - A[0, 1] * b[1], A[0, 0] * b[1] - A[1, 0] * b[0]])


def _lapack_solve(A: Array, b: Array) -> Array:
    matrices = np.ascontiguousarray(np.moveaxis(A, -1, 0))
    right = np.moveaxis(b, -1, 0).reshape(b.shape[-1], len(b), -1)
    try:
        x = np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        # The sign is 0 where elimination met a zero pivot, which is what made `solve` raise; a determinant
        # may also underflow, or be 0 * inf.
        with np.errstate(invalid="ignore"):
            singular = np.linalg.slogdet(matrices).sign == 0.0
        x = np.linalg.solve(np.where(singular[:, None, None], np.nan, matrices), right)
    return np.moveaxis(x, 0, -1).reshape(b.shape)
