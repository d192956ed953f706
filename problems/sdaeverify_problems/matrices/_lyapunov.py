"""The equation M Lambda + Lambda M^T = R for symmetric matrices of size p, paths last, by a Cayley transform.

With N = Id + M and A = N^{-1} (Id - M) it says Lambda = A Lambda A^T + Q, Q = 2 N^{-1} R N^{-T}, and

    Lambda = (1 + S_k) ... (1 + S_1) (1 + S_0) Q,    S_j X = A^{2^j} X (A^{2^j})^T,

Smith (1968): the series converges where all eigenvalues of M have positive real parts, quickly where M is near Id.
In p (p + 1)/2 unknowns the same equation costs p^6/24 operations instead of some 10 p^3.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.numerics import determinant, eliminated, solve

from ._upper import Upper

# The fourth power of the last power is what is left out. Where it is not small after so many, the dense equation is
# solved.
NEGLIGIBLE, MOST = 5e-5, 7


class Lyapunov(NamedTuple):
    """The matrix of the equation in multipliers lambda with Lambda_ij = lambda_ij and Lambda_ii = 2 lambda_ii.

    Attributes
    ----------
    M, inverse : ndarray, shape (p, p, P)
        M and N^{-1}.
    powers : tuple of ndarray, shape (p, p, P)
        A, A^2, A^4 and so on.
    poor : ndarray of bool, shape (P,)
        Where the series does not converge, or slowly.
    """

    M: Array
    inverse: Array
    powers: tuple[Array, ...]
    poor: Mask

    @classmethod
    def of(cls, M: Array) -> "Lyapunov":
        """Return the equation, prepared for any number of right sides."""
        with np.errstate(all="ignore"):
            inverse, A = cayley_transform(M)
            powers = [A]
            # Written so that a NaN counts as poor.
            while (poor := ~(_size(powers[-1]) <= NEGLIGIBLE)).any() and len(powers) < MOST:
                powers.append(product(powers[-1], powers[-1]))
        return cls(M, inverse, tuple(powers), poor)

    def solve(self, b: Array) -> Array:
        """Return lambda from the entries of R on and above the diagonal; shape (q, P) or (q, k, P)."""
        upper = Upper.of(len(self.M))
        with np.errstate(all="ignore"):
            X = series(self.inverse, self.powers, b[upper.number])
        c: Array = X[upper.i, upper.j]
        c[upper.diagonal] *= 0.5
        if self.poor.any():
            c[..., self.poor] = solve(dense(self.M[..., self.poor]), b[..., self.poor])
        return c

    def positive(self) -> Mask:
        """Tell on which paths the determinant is positive, shape (P,): wherever the series converges."""
        if not self.poor.any():
            return ~self.poor
        positive = ~self.poor
        with np.errstate(all="ignore"):
            positive[self.poor] = determinant(dense(self.M[..., self.poor])) > 0.0
        return positive


def cayley_transform(M: Array) -> tuple[Array, Array]:
    """Return N^{-1} and A, shape (p, p, P)."""
    unit = np.eye(len(M))[..., None]
    inverse = eliminated(M + unit).solve(np.broadcast_to(unit, M.shape))
    return inverse, 2.0 * inverse - unit


def series(inverse: Array, powers: Iterable[Array], R: Array) -> Array:
    """Return Lambda up to A^n Lambda (A^n)^T, n twice that of the last power, from R of shape (p, p, ..., P)."""
    X = congruence(inverse, 2.0 * R)
    for power in powers:
        X = X + congruence(power, X)
    return X


def product(A: Array, B: Array) -> Array:
    """Return A B on every path; shapes (n, p, P), (p, m, P) -> (n, m, P)."""
    return np.asarray(np.einsum("nkP,kmP->nmP", A, B))


def transposed_product(A: Array, B: Array) -> Array:
    """Return A^T B on every path; shapes (n, p, P), (n, m, P) -> (p, m, P)."""
    return np.asarray(np.einsum("niP,njP->ijP", A, B))


def congruence(A: Array, X: Array) -> Array:
    """Return A X A^T on every path; shapes (p, p, P), (p, p, ..., P) -> (p, p, ..., P)."""
    half = np.einsum("ikP,kj...P->ij...P", A, X)
    return np.asarray(np.einsum("ik...P,jkP->ij...P", half, A))


def dense(M: Array) -> Array:
    """Return the matrix of the equation, shape (p, p, P) -> (q, q, P).

    The image of E_ab + E_ba, twice E_aa for a = b, has the entries M_ia d_bj + M_ib d_aj + M_ja d_bi + M_jb d_ai.
    """
    upper, unit = Upper.of(len(M)), np.eye(len(M))[..., None]
    i, j = upper.i[:, None], upper.j[:, None]
    a, b = upper.i[None], upper.j[None]
    return np.asarray(M[i, a] * unit[b, j] + M[i, b] * unit[a, j] + M[j, a] * unit[b, i] + M[j, b] * unit[a, i])


def _size(A: Array) -> Array:
    return np.asarray(np.sqrt((np.abs(A) ** 2).sum(axis=(0, 1))))
