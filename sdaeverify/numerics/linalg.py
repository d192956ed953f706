"""Small linear algebra on every path at once, paths last."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..arrays import Array, Mask

# Systems of up to this many equations are solved by Cramer's rule.
EXPLICIT = 2


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
        # With one column, a product takes a third of the time of the general sum.
        return np.asarray(A[:, 0] * x[0])
    product: Array = np.einsum("mnp,n...p->m...p", A, x)
    return product


def apply_transposed(A: Array, y: Array) -> Array:
    """Return A^T y on every path; shapes (m, n, P), (m, ..., P) -> (n, ..., P)."""
    if len(A) == 1 and y.ndim == 2:
        return np.asarray(A[0] * y[0])
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
    A : ndarray, shape (m, m, P) or (m, m, 1)
    b : ndarray, shape (m, P) or (m, k, P)

    Returns
    -------
    ndarray, shape of b
    """
    if len(b) > EXPLICIT:
        return _solve_with_one(A[..., 0], b) if A.shape[-1] == 1 else _lapack_solve(A, b)
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
    sizes = np.abs(x)
    return np.asarray(sizes[0] if len(x) == 1 else np.maximum.reduce(sizes))


def norm(x: Array) -> Array:
    """Return the Euclidean norm of every path; shape (n, P) -> (P,)."""
    length: Array = np.abs(x[0]) if len(x) == 1 else np.sqrt(np.einsum("np,np->p", x, x))
    return length


def all_finite(x: Array) -> Mask:
    """Return the paths that are finite in every component; shape (n, P) -> (P,)."""
    # The sum of a path is finite only if all of its components are; an overflow of the sum counts as not finite.
    finite: Mask = np.isfinite(x.sum(axis=0))
    return finite


def _adjugate_times(A: Array, b: Array) -> Array:
    ((p, q), (r, s)), (x, y) = A, b
    first = s * x - q * y
    # Filled in place, because `numpy.stack` takes five times as long.
    both = np.empty((2, *first.shape), dtype=first.dtype)
    both[0] = first
    np.subtract(p * y, r * x, out=both[1])
    return both


def _solve_with_one(A: Array, b: Array) -> Array:
    # A matrix shared by all paths is inverted once; with a factorisation, the bits of a path would depend on the
    # number of paths.
    try:
        return np.asarray(np.einsum("mn,n...->m...", np.linalg.inv(A), b))
    except np.linalg.LinAlgError:
        return np.full(b.shape, np.nan)


def _lapack_solve(A: Array, b: Array) -> Array:
    matrices = np.ascontiguousarray(A.transpose(2, 0, 1))
    right = b.reshape(len(b), -1, b.shape[-1]).transpose(2, 0, 1)
    try:
        x = np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        # The sign is 0 where elimination met a zero pivot, which made `solve` raise. A determinant is no substitute:
        # it may underflow, or be 0 * inf.
        with np.errstate(invalid="ignore"):
            singular = np.linalg.slogdet(matrices).sign == 0.0
        x = np.linalg.solve(np.where(singular[:, None, None], np.nan, matrices), right)
    return x.transpose(1, 2, 0).reshape(b.shape)


# Tridiagonal systems on every path at once, by elimination along the chain: O(m) a path.


class Tridiagonal(NamedTuple):
    """A tridiagonal matrix A on every path.

    Elimination without row exchanges (Thomas' algorithm): backward stable for matrices that are symmetric and
    positive definite, or diagonally dominant, or near one of these. A vanishing pivot gives non-finite numbers on its
    path only.

    Attributes
    ----------
    lower, upper : ndarray, shape (m - 1, P)
        A_{i+1,i} and A_{i,i+1}.
    diagonal : ndarray, shape (m, P)
    """

    lower: Array
    diagonal: Array
    upper: Array

    def solve(self, b: Array) -> Array:
        """Solve A x = b for b of shape (m, P) or (m, k, P)."""
        factors, pivots = self._eliminate()
        x = list(b)
        for i in range(1, len(x)):
            x[i] = x[i] - factors[i - 1] * x[i - 1]
        x[-1] = x[-1] / pivots[-1]
        for i in range(len(x) - 2, -1, -1):
            x[i] = (x[i] - self.upper[i] * x[i + 1]) / pivots[i]
        return np.stack(x)

    def positive(self) -> Mask:
        """Return the paths on which det A > 0, the product of the pivots; shape (P,)."""
        pivots = np.stack(self._eliminate()[1])
        # Product of signs, because the product itself may overflow or underflow; the sign of NaN is NaN.
        positive: Mask = np.sign(pivots).prod(axis=0) > 0.0
        return positive

    def _eliminate(self) -> tuple[list[Array], list[Array]]:
        # Return the factors of the elimination, and the pivots.
        factors, pivots = [], [self.diagonal[0]]
        for i in range(len(self.lower)):
            factors.append(self.lower[i] / pivots[i])
            pivots.append(self.diagonal[i + 1] - factors[i] * self.upper[i])
        return factors, pivots


# Gaussian elimination of small systems on every path at once, paths last, reused for many right-hand sides.


# Rounding errors are some eps |L| |U|; from this multiple of |A| on, three digits are lost, and pivoting pays off.
GROWTH = 1e3


class Elimination(NamedTuple):
    """Factorisation A = L U, without row exchanges, into a unit lower triangle L and an upper triangle U.

    For matrices that are nearly symmetric and positive definite, whose pivots are large enough. Systems of other
    paths are solved with pivoting.

    Attributes
    ----------
    A : ndarray, shape (m, m, P)
    factors : ndarray, shape (m, m, P)
        U on and above the diagonal, L below it.
    poor : ndarray of bool, shape (P,)
        Whether |L| |U| is much larger than |A|, or not finite.
    """

    A: Array
    factors: Array
    poor: Mask

    def solve(self, b: Array) -> Array:
        """Solve A x = b; shape (m, P) or (m, k, P)."""
        x = _substitute(self.factors, b)
        if self.poor.any():
            x[..., self.poor] = solve(self.A[..., self.poor], b[..., self.poor])
        return x

    def positive(self) -> Mask:
        """Return the paths with det A > 0, shape (P,): an even number of negative pivots and no zero pivot."""
        pivots = np.einsum("kkp->kp", self.factors)
        odd = np.count_nonzero(pivots < 0.0, axis=0) % 2 == 1
        return np.asarray(np.isfinite(pivots).all(axis=0) & (pivots != 0.0).all(axis=0) & ~odd)


def eliminated(A: Array) -> Elimination:
    """Return the factorisation of A, shape (m, m, P), in m - 1 steps vectorised over paths."""
    F = A.copy()
    with np.errstate(all="ignore"):
        for k in range(len(A) - 1):
            F[k + 1 :, k] /= F[k, k]
            F[k + 1 :, k + 1 :] -= F[k + 1 :, k, None] * F[k, k + 1 :]
        sizes, above = np.abs(F), np.triu(np.ones((len(A), len(A)), dtype=bool))
        growth = sizes[above].max(axis=0) * sizes[~above].max(axis=0, initial=1.0) / np.abs(A).max(axis=(0, 1))
    # Written so that a NaN counts as poor.
    poor = ~(growth <= GROWTH)
    return Elimination(A, F, poor)


def _substitute(F: Array, b: Array) -> Array:
    x, m = np.array(b, dtype=np.result_type(b, F, float)), len(F)
    with np.errstate(all="ignore"):
        for k in range(1, m):
            x[k] -= np.einsum("jp,j...p->...p", F[k, :k], x[:k])
        for k in reversed(range(m)):
            if k < m - 1:
                x[k] -= np.einsum("jp,j...p->...p", F[k, k + 1 :], x[k + 1 :])
            x[k] /= F[k, k]
    return x


@dataclass(frozen=True, eq=False)
class Dense:
    """A dense matrix, factorised once for all right-hand sides.

    Attributes
    ----------
    matrix : ndarray, shape (m, m, P) or (m, m, 1)
    """

    matrix: Array

    def solve(self, b: Array) -> Array:
        """Solve A x = b; shape (m, P) or (m, k, P)."""
        direct = len(self.matrix) <= EXPLICIT or self.matrix.shape[-1] == 1
        return solve(self.matrix, b) if direct else self._factors.solve(b)

    def positive(self) -> Mask:
        """Return the paths on which det A > 0, shape (P,)."""
        positive = determinant(self.matrix) > 0.0 if len(self.matrix) <= EXPLICIT else self._factors.positive()
        return np.asarray(positive)

    @cached_property
    def _factors(self) -> Elimination:
        return eliminated(self.matrix)


def antisymmetric(A: Array, l: int) -> Array:
    """Return the areas of pairs, shape (l (l - 1)/2, P), as antisymmetric matrices, shape (l, l, P)."""
    i, j = np.triu_indices(l, k=1)
    matrix = np.zeros((l, l, *A.shape[1:]))
    matrix[i, j], matrix[j, i] = A, -A
    return matrix
