"""Linear equations dx = -(K + P/eps)(x - m) dt + sigma dW with an orthogonal projector P, accurate for any eps."""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array

from .._gaussian_step import project_kernel
from ._stiff_modes import Mode

NODES = 16


class Step(NamedTuple):
    """One step x+ = x + change (x - m) + sigma ( of_dW dW + of_H H + of_xi xi ) with matrices of shape (d, d)."""

    change: Array
    of_dW: Array
    of_H: Array
    of_xi: Array


class StiffLinear(NamedTuple):
    """A linear equation as a sum of modes.

    Attributes
    ----------
    modes : tuple of Mode
    m : ndarray, shape (d,)
    sigma : float
    """

    modes: tuple[Mode, ...]
    m: Array
    sigma: float

    def change(self, t: float) -> Array:
        """Return e^{-(K + P/eps) t} - Id, or its part in the kernel of P if eps is 0; exactly 0 for t = 0."""
        return np.asarray(sum(mode.E @ (mode.decay(t) - np.eye(len(mode.A))) @ mode.F for mode in self.modes))

    def covariance(self, t: float = np.inf) -> Array:
        """Return the covariance at time t for a fixed initial value, or the invariant one: AX + XA^T = sigma^2 Id."""
        total = np.zeros((len(self.m), len(self.m)))
        for a in self.modes:
            for b in self.modes:
                X = scipy.linalg.solve_sylvester(a.matrix, b.matrix.T, self.sigma**2 * a.F @ b.F.T)
                gone = 0.0 if t == np.inf else a.decay(t) @ X @ b.decay(t).T
                total += a.E @ (X - gone) @ b.E.T
        return total

    def slowest(self) -> float:
        """Return the smallest rate at which the difference of two solutions decays."""
        return float(min(np.linalg.eigvals(mode.matrix).real.min() for mode in self.modes))

    def step(self, h: float) -> Step:
        """Return the exact step on a given Brownian path.

        With q = (h-s)/h the kernels of dW and H on [0, h] are 1 and q - 1/2: the coefficients are the projections of
        the kernel e^{-(K + P/eps) h q}, and a root of the covariance of the remainder. The quadrature uses intervals
        that are refined geometrically towards q = 0, down to the scale of the fastest decay.
        """
        q, w = _graded_rule(h * max(np.linalg.norm(mode.matrix, 2) for mode in self.modes))
        kernel = np.asarray(sum(mode.E @ mode.decay(h * q) @ mode.F for mode in self.modes))
        alpha, beta, rho = project_kernel(kernel, q, w)
        return Step(self.change(h), alpha, beta, np.sqrt(h) * rho)


def _graded_rule(z: float) -> tuple[Array, Array]:
    """Return Gauss' nodes and weights on [0, 2^-k], [2^-k, 2^(1-k)], ..., [1/2, 1] with z 2^-k below 1."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    ends = np.concatenate([[0.0], 2.0 ** -np.arange(1.0 + np.ceil(np.log2(max(z, 1.0))), -1.0, -1.0)])
    lengths = np.diff(ends)
    return (ends[:-1, None] + 0.5 * lengths[:, None] * (1.0 + x)).ravel(), (0.5 * lengths[:, None] * w).ravel()
