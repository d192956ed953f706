"""Langevin dynamics with a linear drift and an affine constraint: its exact law, and that of the schemes."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from ._stiff_linear import StiffLinear
from ._stiff_modes import modes


class Recursion(NamedTuple):
    """A step x+ = M x + r + N xi with independent xi of mean 0 and variance 1.

    Attributes
    ----------
    M, N : ndarray, shape (d, d)
    r : ndarray, shape (d,)
    """

    M: Array
    r: Array
    N: Array

    def moments(self, x: Array, steps: int) -> tuple[Array, Array]:
        """Return mean and covariance after some steps from x, shapes (d,) and (d, d)."""
        covariance = np.zeros_like(self.M)
        for _ in range(steps):
            x, covariance = self.M @ x + self.r, self.M @ covariance @ self.M.T + self.N @ self.N.T
        return x, covariance


class AffineLangevin(NamedTuple):
    """f(x) = -K x + k, zeta(x) = B^T x - b and noise of strength sigma, with P the projector onto the range of B.

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
        """An orthonormal basis of the range of B, shape (d, q)."""
        return np.linalg.qr(self.B)[0]

    @property
    def P(self) -> Array:
        """B (B^T B)^{-1} B^T."""
        return self.normals @ self.normals.T

    @property
    def p(self) -> Array:
        """The point of the flat zeta = 0 that is closest to 0."""
        return np.asarray(self.B @ np.linalg.solve(self.B.T @ self.B, self.b))

    def law(self) -> StiffLinear:
        """Return the solution's equation dx = -(K + P/eps)(x - m) dt + sigma dW, or its limit."""
        parts, forces = modes(self.K, self.normals, self.eps), self.k - self.K @ self.p
        shift = sum(part.E @ np.linalg.solve(part.matrix, part.F @ forces) for part in parts)
        return StiffLinear(parts, self.p + shift, self.sigma)

    def explicit_euler(self, h: float) -> Recursion:
        """Return the step (1.5), for eps > 0: M = Id - hK - (h/eps) P, N = sqrt(h) sigma Id."""
        one = np.eye(len(self.k))
        M = one - h * self.K - h / self.eps * self.P
        return Recursion(M, h * self.k + h / self.eps * self.p, np.sqrt(h) * self.sigma * one)

    def constrained_euler(self, h: float) -> Recursion:
        """Return the steps (1.6) and (2.7), with Pi = Id - P: M = Pi (Id - hK), N = sqrt(h) sigma Pi."""
        one = np.eye(len(self.k))
        Pi = one - self.P
        return Recursion(Pi @ (one - h * self.K), h * Pi @ self.k + self.p, np.sqrt(h) * self.sigma * Pi)

    def uniformly_accurate(self, h: float) -> Recursion:
        """Return the step (2.2), whatever theta is.

        With e = exp(-h/eps), M = Pi (Id - hK) + eP - eps (1 - e) PK and
        N = sqrt(h) sigma Pi + sigma sqrt((eps/2) (1 - e^2)) P.
        """
        M, r, N = self.constrained_euler(h)
        if self.eps == 0.0:
            return Recursion(M, r, N)
        e, gone = np.exp(-h / self.eps), -np.expm1(-h / self.eps)
        root = np.sqrt(-0.5 * self.eps * np.expm1(-2.0 * h / self.eps))
        P, slow = self.P, self.eps * gone
        return Recursion(
            M + e * P - slow * P @ self.K,
            r + slow * P @ self.k - e * self.p,
            N + self.sigma * root * P,
        )
