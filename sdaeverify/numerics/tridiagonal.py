"""Tridiagonal systems on every path at once, by elimination along the chain: O(m) a path."""

from typing import NamedTuple

import numpy as np

from ..arrays import Array, Mask


class Tridiagonal(NamedTuple):
    """A tridiagonal matrix A on every path.

    Elimination goes without exchanging rows (Thomas' algorithm): it is backward stable for matrices that are
    symmetric and positive definite, or diagonally dominant, or near one of these. A vanishing pivot gives
    non-finite numbers on its path only.

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
        factors, pivots = self._eliminated()
        x = list(b)
        for i in range(1, len(x)):
            x[i] = x[i] - factors[i - 1] * x[i - 1]
        x[-1] = x[-1] / pivots[-1]
        for i in range(len(x) - 2, -1, -1):
            x[i] = (x[i] - self.upper[i] * x[i + 1]) / pivots[i]
        return np.stack(x)

    def positive(self) -> Mask:
        """Tell on which paths det A > 0, the product of the pivots; shape (P,)."""
        pivots = np.stack(self._eliminated()[1])
        # Signs, because the product itself may overflow or underflow; that of NaN is NaN.
        positive: Mask = np.sign(pivots).prod(axis=0) > 0.0
        return positive

    def _eliminated(self) -> tuple[list[Array], list[Array]]:
        # Factors of the elimination, and the pivots.
        factors, pivots = [], [self.diagonal[0]]
        for i in range(len(self.lower)):
            factors.append(self.lower[i] / pivots[i])
            pivots.append(self.diagonal[i + 1] - factors[i] * self.upper[i])
        return factors, pivots
