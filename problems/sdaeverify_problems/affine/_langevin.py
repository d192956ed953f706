"""Langevin dynamics with a linear drift and an affine constraint, and its exact law."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from ._stiff_linear import StiffLinear
from ._stiff_modes import modes


class AffineLangevin(NamedTuple):
    """Data with f(x) = -K x + k, zeta(x) = B^T x - b and noise of strength sigma; P is the projector onto range B.

    Attributes
    ----------
    K : ndarray, shape (d, d)
    k : ndarray, shape (d,)
    B : ndarray, shape (d, q)
    b : ndarray, shape (q,)
    sigma, eps : float

    Source
    ------
    Laurent (2022), (1.2), (1.4), (1.5), (1.6) and (2.2) for this zeta, whose second derivatives vanish.
    """

    K: Array
    k: Array
    B: Array
    b: Array
    sigma: float
    eps: float

    @property
    def normals(self) -> Array:
        """Orthonormal basis of the range of B, shape (d, q)."""
        return np.linalg.qr(self.B)[0]

    @property
    def P(self) -> Array:
        """Projector B (B^T B)^{-1} B^T, shape (d, d)."""
        return self.normals @ self.normals.T

    @property
    def p(self) -> Array:
        """Point of the flat zeta = 0 that is closest to 0, shape (d,)."""
        return np.asarray(self.B @ np.linalg.solve(self.B.T @ self.B, self.b))

    def law(self) -> StiffLinear:
        """Return the equation dx = -(K + P/eps)(x - m) dt + sigma dW of the solution, or its limit if eps is 0."""
        parts, forces = modes(self.K, self.normals, self.eps), self.k - self.K @ self.p
        shift = sum(part.E @ np.linalg.solve(part.matrix, part.F @ forces) for part in parts)
        return StiffLinear(parts, self.p + shift, self.sigma)
