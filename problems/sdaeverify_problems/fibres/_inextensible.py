"""The constraint of an inextensible chain, g_{i-1/2} = (1 - |r_i - r_{i-1}|^2/ds^2)/2, in O(N) operations per path.

Lindner et al. (2018), (2.7). With e_i = r_i - r_{i-1}:

    (Dg y)_i = -<e_i, y_i - y_{i-1}>/ds^2,   (grad g c)_i = (e_{i+1} c_{i+1} - e_i c_i)/ds^2,

where y_0 = 0 at a clamp, and c = 0 on unconstrained edges.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.numerics import Tridiagonal

from ._chain import Chain

# C_g is a supremum over the points within EPS ds of the manifold.
EPS = 0.01


class ChainJacobian(NamedTuple):
    """Jacobian Dg at one position per path.

    Attributes
    ----------
    chain : Chain
    e : ndarray, shape (m, d, P)
    """

    chain: Chain
    e: Array

    def times(self, y: Array) -> Array:
        """Return Dg y, shape (n, P) or (n, k, P) -> (m, P) or (m, k, P)."""
        e = self.e if y.ndim == 2 else self.e[:, :, None]
        return dots(e, self.chain.differences(y)) / -(self.chain.ds**2)

    def transposed(self, c: Array) -> Array:
        """Return grad g c, shape (m, P) or (m, k, P) -> (n, P) or (n, k, P)."""
        e = self.e if c.ndim == 2 else self.e[:, :, None]
        pull = e * (c / self.chain.ds**2)[:, None]
        zero = np.zeros_like(pull[:1])
        padded = np.concatenate([pull, zero] if self.chain.root is not None else [zero, pull, zero])
        return np.reshape(padded[1:] - padded[:-1], (-1, *pull.shape[2:]))

    def gram(self, other: "ChainJacobian") -> Tridiagonal:
        """Return Dg grad g for edges e and f of `other`, the bands 2 <e_i, f_i> and -<e_i, f_{i+-1}> over ds^4.

        At a clamp the first diagonal entry is <e_1, f_1>/ds^4.
        """
        e, f, scale = self.e, other.e, self.chain.ds**-4
        diagonal = dots(e, f) * (2.0 * scale)
        if self.chain.root is not None:
            diagonal[0] *= 0.5
        upper = dots(e[:-1], f[1:]) * -scale
        lower = upper if other is self else dots(e[1:], f[:-1]) * -scale
        return Tridiagonal(lower, diagonal, upper)

    def size(self) -> Array:
        """Return the Frobenius norm of Dg, shape (P,)."""
        squares = 2.0 * dots(self.e, self.e)
        if self.chain.root is not None:
            squares[0] *= 0.5
        total: Array = np.sqrt(squares.sum(axis=0))
        return total / self.chain.ds**2


def constraint(chain: Chain, r: Array) -> Array:
    """Return g(r), shape (m, P)."""
    e = chain.edges(r)
    return 0.5 - dots(e, e) * (0.5 / chain.ds**2)


def curvature(chain: Chain, r: Array, y: Array, z: Array) -> Array:
    """Return D^2 g(y, z) = -<y_i - y_{i-1}, z_i - z_{i-1}>/ds^2, shape (m, P)."""
    return dots(chain.differences(y), chain.differences(z)) / -(chain.ds**2)


def dense(chain: Chain, r: Array) -> Array:
    """Return the matrix Dg(r), shape (m, n, P)."""
    return ChainJacobian(chain, chain.edges(r)).times(np.eye(len(r))[..., None])


def bound(chain: Chain) -> float:
    """Return C_g of Lindner & Stroot (2.7) for displacements of at most EPS ds.

    Let T/ds^2 be the Gram matrix of the straight chain: 2 and -1, with T_11 = 1 at a clamp. In general
    |G_ij| <= |T_ij| |e_i| |e_j|/ds^4, where signs off the diagonal do not matter to the eigenvalues of a tridiagonal
    matrix: the eigenvalues of G lie between the least and the largest one of T, times the least and the largest
    |e|^2/ds^4, and ||e| - ds| <= sqrt(2) EPS ds. The maximum is attained by |G| or |G^{-1}|: |grad g| = |G|^(1/2) and
    |D^2 g| <= (2 |T|)^(1/2)/ds^2 are smaller, because |T| >= 2 and ds < 1.
    """
    m = chain.N - (chain.root is None)
    T = 2.0 * np.eye(m) - np.eye(m, k=1) - np.eye(m, k=-1)
    T[0, 0] -= chain.root is not None
    least, largest = np.linalg.eigvalsh(T)[[0, -1]]
    stretch = np.sqrt(2.0) * EPS
    return float(max(largest * ((1.0 + stretch) / chain.ds) ** 2, (chain.ds / (1.0 - stretch)) ** 2 / least))


def dots(e: Array, f: Array) -> Array:
    """Return <e_i, f_i> of vectors along the second axis: (m, d, ..., P) -> (m, ..., P)."""
    total: Array = e[:, 0] * f[:, 0]
    for k in range(1, e.shape[1]):
        total = total + e[:, k] * f[:, k]
    return total
