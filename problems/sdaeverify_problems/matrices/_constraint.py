"""The constraint x^T x = Id for d x p matrices x, stored by rows: the entries on and above the diagonal.

Symbols: C = x^T x, Z = C - Id, and Lambda, the symmetric matrix of multipliers with g lambda = x Lambda.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from ._lyapunov import Lyapunov, transposed_product
from ._upper import Upper


class MatrixJacobian(NamedTuple):
    """The linearised constraint y -> x^T y + y^T x.

    Attributes
    ----------
    x : ndarray, shape (d, p, P)
    """

    x: Array

    def times(self, y: Array) -> Array:
        """Return g^T y, shape (d p, P) or (d p, k, P) -> (q, P) or (q, k, P)."""
        d, p, _ = self.x.shape
        half = np.einsum("niP,nj...P->ij...P", self.x, y.reshape(d, p, *y.shape[1:]))
        upper = Upper.of(p)
        return np.asarray(half[upper.i, upper.j] + half[upper.j, upper.i])

    def transposed(self, c: Array) -> Array:
        """Return g c = x Lambda, shape (q, P) or (q, k, P) -> (d p, P) or (d p, k, P)."""
        d, p, _ = self.x.shape
        multiplier = c[Upper.of(p).number]
        multiplier[np.arange(p), np.arange(p)] *= 2.0
        return np.asarray(np.einsum("niP,ij...P->nj...P", self.x, multiplier).reshape(d * p, *c.shape[1:]))

    def gram(self, other: "MatrixJacobian") -> Lyapunov:
        """Return the matrix of Lambda -> M Lambda + Lambda M^T with M = x^T y, y the matrix of the other."""
        return Lyapunov.of(transposed_product(self.x, other.x))

    def size(self) -> Array:
        """Return the Frobenius norm of g, shape (P,): |g|^2 = (p + 3) |x|^2."""
        # Column i of x is in the gradients of p - 1 products, and doubled in that of its square.
        return np.asarray(np.sqrt((self.x.shape[1] + 3.0) * (self.x * self.x).sum(axis=(0, 1))))


def zeta(p: int, x: Array) -> Array:
    """Return the entries of x^T x - Id, shape (d p, P) -> (q, P)."""
    rows, upper = x.reshape(-1, p, x.shape[-1]), Upper.of(p)
    products = transposed_product(rows, rows)
    return np.asarray(products[upper.i, upper.j] - upper.diagonal[:, None])


def jacobian(p: int, x: Array) -> Array:
    """Return g^T, shape (d p, P) -> (q, d p, P)."""
    rows, upper = x.reshape(-1, p, x.shape[-1]), Upper.of(p)
    q = np.arange(len(upper.i))
    Dg = np.zeros((len(q), *rows.shape), dtype=x.dtype)
    Dg[q, :, upper.i] += np.swapaxes(rows, 0, 1)[upper.j]
    Dg[q, :, upper.j] += np.swapaxes(rows, 0, 1)[upper.i]
    return Dg.reshape(len(q), *x.shape)


def hessians(d: int, p: int) -> Array:
    """Return H_k, shape (q, d p, d p)."""
    upper = Upper.of(p)
    H = np.zeros((len(upper.i), p, p))
    q = np.arange(len(upper.i))
    H[q, upper.i, upper.j] += 1.0
    H[q, upper.j, upper.i] += 1.0
    return np.asarray(np.einsum("nm,kij->knimj", np.eye(d), H).reshape(len(q), d * p, d * p))
