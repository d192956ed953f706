"""Mean and covariance of dx = (A x + a) dt + dN by the exponential of their own linear equations."""

import numpy as np
from scipy.linalg import block_diag, expm

from sdaeverify import Array


def moments_at(A: Array, a: Array, Q: Array, start: Array, t: float) -> tuple[Array, Array]:
    """Return the solution of m' = A m + a, C' = A C + C A^T + Q from a point, shapes (n,) and (n, n)."""
    n, one = len(a), np.eye(len(a))
    L = block_diag(0.0, A, np.kron(A, one) + np.kron(one, A))
    L[1:, 0] = np.concatenate([a, Q.ravel()])
    end = expm(t * L) @ np.concatenate([[1.0], start, np.zeros(n * n)])
    return end[1 : n + 1], end[n + 1 :].reshape(n, n)
