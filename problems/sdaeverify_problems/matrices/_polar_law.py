"""Invariant law around SO(m), m = 2 and 3, with f = -kappa (x - Id), by quadrature.

With a = 2 kappa/sigma^2 and x = U diag(s) V^T, U and V of SO(m), the density is

    prod_{i<j} |s_i^2 - s_j^2| (s_i^2 + s_j^2)^{1/2} (prod_i s_i)^{1 + 1/(sigma^2 eps)}
        exp(-|s|^2 (1/(2 sigma^2 eps) + kappa/sigma^2)) Z(a s),    Z(s) = int exp(tr(Q diag(s))) dQ over SO(m).

Z is a Bessel function for m = 2, an integral over an interval for m = 3. The error of E tr x is about 1e-8.
"""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array

# Numbers of Gauss nodes for gaps of singular values and for the interval of Z. The trapezoidal rule in the logarithm
# of the smallest singular value, of width w, has the step w/FINE, at most COARSEST; the integrand is negligible
# beyond REACH w, or where an exponential has decreased by e^{-FALLEN}.
GAPS, INTERVAL = 24, 24
FINE, COARSEST, REACH, FALLEN = 2.0, 0.15, 9.0, 36.0


class PolarLaw(NamedTuple):
    """Parameters of the law.

    Attributes
    ----------
    eps, kappa, sigma : float
        Positive.
    m : int
        Number of rows, 2 or 3.
    """

    eps: float
    kappa: float
    sigma: float
    m: int

    @property
    def pull(self) -> float:
        """The ratio a = 2 kappa/sigma^2."""
        return 2.0 * self.kappa / self.sigma**2

    def trace(self) -> float:
        """Return E tr x under the invariant law."""
        s, log = self._singular_values()
        log = log + self.pull * s.sum(axis=0)
        kept = log > log.max() - FALLEN
        Z, slope = (rotations, rotations_in_space)[self.m - 2](self.pull, s[:, kept])
        weights = np.exp(log[kept] - log.max())
        return float((weights * slope).sum() / (weights * Z).sum())

    def _singular_values(self) -> tuple[Array, Array]:
        """Return s_1 >= ... >= s_m, shape (m, Q), and the logarithms of weight times density without Z."""
        power, decay = 1.0 / (self.sigma**2 * self.eps), 1.0 / (2.0 * self.sigma**2 * self.eps)
        width = self.sigma / np.sqrt(2.0 * (self.kappa + 1.0 / self.eps))
        u = np.arange(-REACH * width - FALLEN / (2.0 + power), np.log1p(REACH * width), min(width / FINE, COARSEST))
        gap, weight = np.polynomial.legendre.leggauss(GAPS)
        gap, weight = 0.5 * (gap + 1.0) * (REACH + self.m) * width, np.log(weight)
        grids = np.meshgrid(*[gap] * (self.m - 1), u, indexing="ij")
        weights = np.meshgrid(*[weight] * (self.m - 1), u, indexing="ij")
        gaps, smallest = [grid.ravel() for grid in grids[:-1]], np.exp(grids[-1].ravel())
        s = np.stack([smallest + sum(gaps[i:], np.zeros_like(smallest)) for i in range(self.m)])
        log = np.sum(weights, axis=0).ravel() + np.log(s).sum(axis=0)
        # s^power exp(-decay s^2) up to its largest value, which is at s = 1.
        log += (power * np.log(s) - decay * (s - 1.0) * (s + 1.0) - 0.5 * self.pull * s**2).sum(axis=0)
        for i in range(self.m):
            for j in range(i + 1, self.m):
                log += np.log(s[i] ** 2 - s[j] ** 2) + 0.5 * np.log(s[i] ** 2 + s[j] ** 2)
        return s, log


def rotations(a: float, s: Array) -> tuple[Array, Array]:
    """Return Z(a s) and its derivative in a, both times exp(-a sum s), for m = 2: Z = I_0(a (s_1 + s_2))."""
    total = s[0] + s[1]
    return scipy.special.i0e(a * total), total * scipy.special.i1e(a * total)


def rotations_in_space(a: float, s: Array) -> tuple[Array, Array]:
    """Return Z(a s) and its derivative in a, scaled as by `rotations`, for m = 3 and s_1 >= s_2 >= s_3.

    Z(s) = int_{-1}^1 I_0((s_2 - s_3) (1 - u)/2) I_0((s_2 + s_3) (1 + u)/2) e^{s_1 u} du/2.
    """
    rate = a * (s[0] + s[2])
    length = np.minimum(2.0, FALLEN / rate)
    nodes, weights = np.polynomial.legendre.leggauss(INTERVAL)
    # 1 - u
    v = 0.5 * (nodes[:, None] + 1.0) * length
    less, more = 0.5 * (s[1] - s[2]) * v, 0.5 * (s[1] + s[2]) * (2.0 - v)
    first, second = scipy.special.i0e(a * less), scipy.special.i0e(a * more)
    kernel = 0.25 * weights[:, None] * length * np.exp(-rate * v)
    slope = (
        less * scipy.special.i1e(a * less) * second
        + first * more * scipy.special.i1e(a * more)
        + s[0] * (1.0 - v) * first * second
    )
    return (kernel * first * second).sum(axis=0), (kernel * slope).sum(axis=0)
