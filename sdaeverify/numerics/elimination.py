"""Gauss's elimination of small systems on every path at once, paths last, to be used for many right sides."""

from typing import NamedTuple

import numpy as np

from ..arrays import Array, Mask
from .linalg import solve

# Rounding errors are some eps |L| |U|: where that is so many times |A|, three digits are lost, and pivoting pays.
GROWTH = 1e3


class Elimination(NamedTuple):
    """A = L U with the unit lower triangle L and the upper triangle U, without exchange of rows.

    For matrices that are nearly symmetric and positive definite, whose pivots are large enough; paths on which they
    are not are solved with pivoting.

    Attributes
    ----------
    A : ndarray, shape (m, m, P)
    factors : ndarray, shape (m, m, P)
        U on and above the diagonal, L below it.
    poor : ndarray of bool, shape (P,)
        Where |L| |U| is much larger than |A|, or not finite.
    """

    A: Array
    factors: Array
    poor: Mask

    def solve(self, b: Array) -> Array:
        """Solve A x = b; shape (m, P) or (m, k, P)."""
        x = _substituted(self.factors, b)
        if self.poor.any():
            x[..., self.poor] = solve(self.A[..., self.poor], b[..., self.poor])
        return x

    def positive(self) -> Mask:
        """Tell on which paths det A > 0, shape (P,): an even number of negative pivots, and none that vanishes."""
        pivots = np.einsum("kkp->kp", self.factors)
        odd = np.count_nonzero(pivots < 0.0, axis=0) % 2 == 1
        return np.asarray(np.isfinite(pivots).all(axis=0) & (pivots != 0.0).all(axis=0) & ~odd)


def eliminated(A: Array) -> Elimination:
    """Return the factors of A, shape (m, m, P), in m steps that each take all paths at once."""
    F, L, U = A.copy(), np.ones(A.shape[-1]), np.zeros(A.shape[-1])
    with np.errstate(all="ignore"):
        for k in range(len(A)):
            if k:
                F[k, k:] -= np.einsum("jp,jip->ip", F[k, :k], F[:k, k:])
                F[k + 1 :, k] -= np.einsum("ijp,jp->ip", F[k + 1 :, :k], F[:k, k])
            F[k + 1 :, k] /= F[k, k]
            U = np.maximum(U, np.abs(F[k, k:]).max(axis=0))
            L = np.maximum(L, np.abs(F[k + 1 :, k]).max(axis=0, initial=0.0))
        growth = L * U / np.abs(A).max(axis=(0, 1))
    # Written so that a NaN counts as poor.
    poor = ~(growth <= GROWTH)
    return Elimination(A, F, poor)


def _substituted(F: Array, b: Array) -> Array:
    x, m = np.array(b, dtype=np.result_type(b, F, float)), len(F)
    with np.errstate(all="ignore"):
        for k in range(1, m):
            x[k] -= np.einsum("jp,j...p->...p", F[k, :k], x[:k])
        for k in reversed(range(m)):
            if k < m - 1:
                x[k] -= np.einsum("jp,j...p->...p", F[k, k + 1 :], x[k + 1 :])
            x[k] /= F[k, k]
    return x
