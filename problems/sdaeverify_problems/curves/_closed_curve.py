"""Brownian motion on a closed curve, by arc length s: E phi(X_t) = E phi(gamma(s_0 + sigma sqrt(t) N)), N normal."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sdaeverify import Array
from sdaeverify.numerics import directional

# Number of points of the trapezoidal rule in the parameter, and of Fourier modes in arc length: converged to rounding
# for ellipses with axes from 1 to 2 and for similarly smooth curves.
POINTS, MODES = 512, 100


@dataclass(frozen=True, eq=False)
class ClosedCurve:
    """A curve x = gamma(theta) of period 2 pi.

    Attributes
    ----------
    gamma : callable, ndarray of shape (1, P) -> ndarray of shape (d, P)
        Parametrisation, analytic because it is differentiated by complex steps.
    sigma : float
        Amplitude of the noise, unit length/sqrt(time).
    """

    gamma: Callable[[Array], Array]
    sigma: float

    @property
    def length(self) -> float:
        """Length L of the curve."""
        return float(2.0 * np.pi * self._speed.mean())

    @property
    def relaxation(self) -> float:
        """Time in which the slowest function e^{2 pi i s/L} decays by a factor e."""
        return 2.0 * (self.length / (2.0 * np.pi * self.sigma)) ** 2

    def arc(self, theta: Array) -> Array:
        """Return the arc length from 0 to theta, by integrating the Fourier series of |gamma'|."""
        waves = np.fft.rfft(self._speed)[1 : POINTS // 2] / POINTS
        k = 1j * np.arange(1.0, POINTS // 2)
        turns = np.exp(np.multiply.outer(theta, k)) - 1.0
        return np.asarray(self._speed.mean() * theta + 2.0 * (turns @ (waves / k)).real)

    def expectation(self, phi: Callable[[Array], Array], theta: float, t: float) -> float:
        """Return E phi(X_t) for X_0 = gamma(theta)."""
        values, k = phi(self.gamma(self._parameters[None])), np.arange(1.0, MODES + 1.0)
        waves = np.exp(-2j * np.pi / self.length * np.outer(k, self.arc(self._parameters)))
        shares = waves @ (values * self._weights)
        here = np.exp(2j * np.pi / self.length * k * self.arc(np.array([theta])))
        faded = np.expm1(-0.5 * t * (2.0 * np.pi * self.sigma * k / self.length) ** 2)
        return float(phi(self.gamma(np.array([[theta]])))[0] + 2.0 * (faded @ (here * shares)).real)

    def mean(self, phi: Callable[[Array], Array]) -> float:
        """Return the mean of phi with respect to arc length, the invariant law."""
        return float(self._weights @ phi(self.gamma(self._parameters[None])))

    @cached_property
    def _parameters(self) -> Array:
        return 2.0 * np.pi * np.arange(POINTS) / POINTS

    @cached_property
    def _speed(self) -> Array:
        theta = self._parameters[None]
        velocity = directional(self.gamma, theta, np.ones_like(theta))
        return np.sqrt((velocity**2).sum(axis=0))

    @cached_property
    def _weights(self) -> Array:
        return np.asarray(self._speed / self._speed.sum())
