"""Decomposition of a matrix K + P/eps with an orthogonal projector P, for accurate matrix functions at any eps.

Rounding the sum perturbs K by rounding errors of size 1/eps. For small eps the matrix is therefore written as

    K + P/eps = E_s (A_s) F_s + E_f (A_f + Id/eps) F_f,      F_i E_j = delta_ij Id,

with A_s and A_f of the size of K; in the limit eps = 0 only the slow part remains, in the kernel of P.
"""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array

# For eps |K| up to SPLIT the parts are computed by TURNS fixed-point iterations, which contract errors by 0.3.
SPLIT, TURNS = 0.125, 40


class Mode(NamedTuple):
    """A part E (A + rate Id) F of a matrix.

    Attributes
    ----------
    E : ndarray, shape (d, m)
    F : ndarray, shape (m, d)
    A : ndarray, shape (m, m)
    rate : float
    """

    E: Array
    F: Array
    A: Array
    rate: float = 0.0

    @property
    def matrix(self) -> Array:
        """The matrix A + rate Id, shape (m, m)."""
        return np.asarray(self.A + self.rate * np.eye(len(self.A)))

    def decay(self, t: float | Array) -> Array:
        """Return e^{-(A + rate) t}, shape (..., m, m) for t of shape (...)."""
        times = np.asarray(t)[..., None, None]
        return np.asarray(np.exp(-self.rate * times) * scipy.linalg.expm(-times * self.A))


def modes(K: Array, N: Array, eps: float) -> tuple[Mode, ...]:
    """Return the parts of K + P/eps, shape (d, d), given an orthonormal basis N of the range of P, shape (d, q)."""
    d, q = N.shape
    T = np.linalg.svd(N)[0][:, q:]
    if eps == 0.0:
        return (Mode(T, T.T, T.T @ K @ T),)
    if eps * np.linalg.norm(K, 2) > SPLIT:
        return (Mode(np.eye(d), np.eye(d), K + N @ N.T / eps),)
    a, b, c, e = T.T @ K @ T, T.T @ K @ N, N.T @ K @ T, N.T @ K @ N
    R, S = np.zeros((q, d - q)), np.zeros((d - q, q))
    for _ in range(TURNS):
        R = -eps * (c + e @ R - R @ (a + b @ R))
    slow, fast = a + b @ R, e - R @ b
    for _ in range(TURNS):
        S = eps * (b + slow @ S - S @ fast)
    one, other = np.eye(d - q), np.eye(q)
    return (
        Mode(T + N @ R, (one + S @ R) @ T.T - S @ N.T, slow),
        Mode(T @ S + N @ (other + R @ S), N.T - R @ T.T, fast, 1.0 / eps),
    )
