"""Operator P -> E A P A^T on symmetric matrices, which maps second moments before a step to those after it.

In the coordinates svec(P) = (P_ii, sqrt(2) P_ij for i < j), in which the Frobenius product is the Euclidean one, the
operator is a matrix of size n (n + 1)/2.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array


class Operator(NamedTuple):
    """Operator P -> sum_k w_k A_k P A_k^T, which maps positive semidefinite matrices to such matrices.

    Attributes
    ----------
    factors : ndarray, shape (n, n, K)
    weights : ndarray, shape (K,)
        Nonnegative.
    """

    factors: Array
    weights: Array

    @property
    def dimension(self) -> int:
        """Number n of rows of P."""
        return len(self.factors)

    @property
    def size(self) -> int:
        """Number n (n + 1)/2 of unknowns."""
        return self.dimension * (self.dimension + 1) // 2

    @property
    def homogeneous(self) -> "Operator":
        """The operator of the linear part, if the factors act on (x, 1)."""
        return Operator(self.factors[:-1, :-1], self.weights)

    def __call__(self, P: Array) -> Array:
        """Return sum_k w_k A_k P A_k^T, shape (..., n, n), for one P or several."""
        n = self.dimension
        # Stack the rows of A_k P and of A_k for all k, so that one matrix product sums over k.
        left = (self.factors * self.weights).swapaxes(1, 2).reshape(-1, n) @ P
        return np.asarray(left.reshape(*P.shape[:-1], -1) @ self.factors.swapaxes(1, 2).reshape(n, -1).T)

    def dense(self) -> Array:
        """Return the matrix in the coordinates svec, shape (size, size)."""
        flat = self.factors.reshape(self.dimension**2, -1)
        return _on_coordinates((flat * self.weights) @ flat.T, self.dimension)


def on_symmetric(matrix: Array, n: int) -> Array:
    """Return the map of svec(P) for a map of row-wise flattened matrices P that preserves symmetry.

    Parameters
    ----------
    matrix : ndarray, shape (n^2, n^2)
    n : int

    Returns
    -------
    ndarray, shape (n (n + 1)/2, n (n + 1)/2)
    """
    return _on_coordinates(matrix.reshape(n, n, n, n).transpose(0, 2, 1, 3), n)


def _on_coordinates(products: Array, n: int) -> Array:
    # Convert the products E A_ai A_bj, in the order (a, i, b, j), to a map of svec(P).
    entries, mirrored, scale = _places(n)
    flat = products.ravel()
    return np.asarray((flat[entries] + flat[mirrored]) * scale)


def _places(n: int) -> tuple[Array, Array, Array]:
    """Return the indices of the products for rows (a, b) and columns (i, j), and for (j, i), and their factor.

    A coordinate off the diagonal stands for two equal entries of P, each of which is the coordinate over sqrt(2).
    """
    i, j, scale = triangle(n)
    a, b = i[:, None], j[:, None]
    return ((a * n + i) * n + b) * n + j, ((a * n + j) * n + b) * n + i, 0.5 * scale[:, None] * scale


def svec(P: Array) -> Array:
    """Return the coordinates of a symmetric matrix, shape (n (n + 1)/2,)."""
    i, j, scale = triangle(len(P))
    return np.asarray(scale * P[i, j])


def smat(coordinates: Array, n: int) -> Array:
    """Return the symmetric matrices with some coordinates, shape (..., n, n): the inverse of `svec`."""
    i, j, scale = triangle(n)
    P = np.empty((*coordinates.shape[:-1], n, n))
    P[..., i, j] = P[..., j, i] = coordinates / scale
    return P


@lru_cache(maxsize=64)
def triangle(n: int) -> tuple[Array, Array, Array]:
    """Return rows and columns of the entries of svec(P), and the factors 1 or sqrt(2) of these entries."""
    i, j = np.triu_indices(n)
    return i, j, np.where(i == j, 1.0, np.sqrt(2.0))
