"""The first two moments of a linear equation dz = A z dt + sum_j B_j z dW_j in the plane."""

from collections.abc import Sequence

import numpy as np
import scipy

from sdaeverify import Array

SOURCE = "linear equations of the first two moments, Arnold 1974, section 8.5"


def generator(A: Array, B: Sequence[Array]) -> Array:
    """Return the matrix G of (E z z^T)' = G E z z^T, read row by row, shape (4, 4)."""
    unit = np.eye(2)
    return np.asarray(np.kron(A, unit) + np.kron(unit, A) + sum(np.kron(b, b) for b in B))


def mean(A: Array, start: Array, t: float) -> Array:
    """Return E z(t) = exp(A t) z(0), shape (2,)."""
    return np.asarray(scipy.linalg.expm(A * t) @ start)


def second(G: Array, start: Array, t: float) -> Array:
    """Return E z(t) z(t)^T from the matrix G of `generator`, shape (2, 2)."""
    return np.asarray(scipy.linalg.expm(G * t) @ np.outer(start, start).ravel()).reshape(2, 2)
