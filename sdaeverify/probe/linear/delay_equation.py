"""Coefficients of linear delay equations, and exact mean-square stability of a scalar one.

    dx = (A x + B x(t - tau)) dt + (c x + d x(t - tau)) dW,     r' = A r + B r(t - tau), r(0) = 1, r = 0 before 0.

E x^2 tends to 0 if and only if the roots of s = A + B e^(-s tau) have negative real parts and the integral of
(c r(t) + d r(t - tau))^2 over t > 0 is below 1. With K(a) the integral of r(t) r(t - a), it is

    (c^2 + d^2) K(0) + 2 c d K(tau),   K(0) = (B sh - 1)/(2 (A + B ch)),   K(tau) = -(ch + A sh)/(2 (A + B ch)),

ch = cosh(w tau), sh = sinh(w tau)/w, w^2 = A^2 - B^2. Numerators and denominator have a common zero, and overflow.
For A <= -|B|, with beta = B/(w - A) and E = e^(-w tau), they are equal to

    K(0) = (1 + E beta)/(2 w (1 - E beta)),   K(tau) = (E + beta)/(2 w (1 - E beta)),

and for B < -|A|, with w^2 = B^2 - A^2, psi = arg(-A + i w) and the slack s = pi - psi - w tau, which is positive if
and only if r decays, to

    K(0) = sin((psi + w tau)/2)/(2 w sin(s/2)),   K(tau) = sin((psi - w tau)/2)/(2 w sin(s/2)).
"""

from typing import NamedTuple

import numpy as np
import scipy

from ...forms import Delayed
from ...numerics.lambert import lambert_of_log
from ..step.nodes import SEED
from ..step.states import WHEN

EPS = float(np.finfo(float).eps)
# Rounding error of a handful of operations, and of the slack per unit of its two terms.
# Rounding: EPS for each operation.
ROUNDING = 32.0 * EPS
# Largest exponent: e^CLIP can be squared without overflow.
# Rounding: e^600 is less than the largest number, e^709.
CLIP = 300.0
# Sizes of the states: 1 in the problem's unit, and sizes for the limits of small and of large states.
# Size: of the trial states.
UNIT, SMALL, LARGE = 1.0, 1e-12, 1e14


class LinearDelay(NamedTuple):
    """The coefficients of dx = (A x + B x(t - tau)) dt + (c x + d x(t - tau)) dW.

    Attributes
    ----------
    A, B : float
        Unit 1/time.
    c, d : float
        Unit 1/sqrt(time).
    tau : float
        Delay, nonnegative.
    """

    A: float
    B: float
    c: float
    d: float
    tau: float

    @property
    def rightmost_root(self) -> complex:
        """Root of s = A + B e^(-s tau) with the largest real part, A + W_0(B tau e^(-A tau))/tau."""
        if self.tau == 0.0 or self.B == 0.0:
            return complex(self.A + (self.B if self.tau == 0.0 else 0.0))
        logarithm = float(np.log(abs(self.B) * self.tau) - self.A * self.tau)
        return complex(self.A + lambert_of_log(logarithm, self.B < 0.0) / self.tau)

    @property
    def mean_decays(self) -> bool | None:
        """Whether all roots have negative real parts (Hayes 1950); None if rounding errors are too large."""
        if self.A + self.B >= 0.0:
            return False
        if self.A <= self.B:
            return True
        slack, error = self._slack
        return None if abs(slack) <= error else slack > 0.0

    @property
    def covariances(self) -> tuple[float, float]:
        """Integrals K(0) of r(t)^2 and K(tau) of r(t) r(t - tau); infinite unless r is known to decay."""
        if not self.mean_decays:
            return np.inf, np.inf
        w = self._frequency
        if w == 0.0:
            return 0.25 * (self.tau - 1.0 / self.B), 0.25 * (-1.0 / self.B - self.tau)
        if self.A <= self.B:
            return _hyperbolic(w, w * self.tau, np.arcsinh(w / abs(self.B)) if self.B else np.inf, self.B < 0.0)
        psi, scale = np.arctan2(w, -self.A), 2.0 * w * np.sin(0.5 * self._slack[0])
        return float(np.sin(0.5 * (psi + w * self.tau)) / scale), float(np.sin(0.5 * (psi - w * self.tau)) / scale)

    @property
    def noise_integral(self) -> float:
        """Integral of (c r(t) + d r(t - tau))^2; infinite unless r is known to decay."""
        at_0, at_tau = self.covariances
        if at_0 == np.inf:
            return np.inf
        return float((self.c**2 + self.d**2) * at_0 + 2.0 * self.c * self.d * at_tau)

    @property
    def noise_integral_error(self) -> float:
        """Bound of the rounding error of the integral, relative to its terms; |K(tau)| is at most K(0)."""
        relative = ROUNDING
        if self.A > self.B:
            slack, error = self._slack
            relative += 2.0 * error / abs(slack)
        return float(relative * (abs(self.c) + abs(self.d)) ** 2 * self.covariances[0])

    @property
    def stable(self) -> bool | None:
        """Whether E x^2 tends to 0; None if rounding errors are too large to decide."""
        if not self.mean_decays:
            return self.mean_decays
        integral, error = self.noise_integral, self.noise_integral_error
        return None if abs(integral - 1.0) <= error else integral < 1.0

    @property
    def growth_rate(self) -> float:
        """Rate lam of E x^2 ~ e^(lam t), unit 1/time.

        It is the rate at which the integral of e^(-lam t) (c r(t) + d r(t - tau))^2, the noise integral of the
        equation discounted by lam, equals 1, or twice the real part of the rightmost root if that is larger. The
        integral decreases in lam; its reciprocal is 0 at the latter, and nearly linear.
        """
        low = 2.0 * self.rightmost_root.real
        width = 1.0 + abs(self.A) + abs(self.B) + (abs(self.c) + abs(self.d)) ** 2
        while self._excess(low + width) <= 0.0:
            width *= 2.0
        root = scipy.optimize.brentq(
            lambda rate: -1.0 if rate <= low else self._excess(rate), low, low + width, xtol=1e-14, rtol=1e-14
        )
        return float(root)

    def discount(self, rate: float) -> "LinearDelay":
        """Return the equation that e^(-rate t/2) x satisfies."""
        factor = float(np.exp(np.clip(-0.5 * rate * self.tau, -CLIP, CLIP)))
        return LinearDelay(self.A - 0.5 * rate, self.B * factor, self.c, self.d * factor, self.tau)

    @property
    def _frequency(self) -> float:
        return float(np.sqrt(abs((self.A - self.B) * (self.A + self.B))))

    @property
    def _slack(self) -> tuple[float, float]:
        w = self._frequency
        angle, turned = float(np.arctan2(w, self.A)), w * self.tau
        return angle - turned, ROUNDING * (angle + turned)

    def _excess(self, rate: float) -> float:
        # Return a value that is negative below the growth rate and positive above.
        if rate <= 2.0 * self.rightmost_root.real:
            return -1.0
        integral = self.discount(rate).noise_integral
        return 1.0 / integral - 1.0 if integral > 0.5 else 1.0


def _hyperbolic(w: float, u: float, psi: float, opposed: bool) -> tuple[float, float]:
    # Here E = e^(-u) and |beta| = e^(-psi); differences are computed in the exponents.
    product, gap = np.exp(-u - psi), -np.expm1(-u - psi)
    if opposed:
        difference = np.sign(psi - u) * np.exp(-min(u, psi)) * -np.expm1(-abs(psi - u))
        return float(gap / (2.0 * w * (1.0 + product))), float(difference / (2.0 * w * (1.0 + product)))
    return float((1.0 + product) / (2.0 * w * gap)), float((np.exp(-u) + np.exp(-psi)) / (2.0 * w * gap))


def linear_delay(view: Delayed, scale: float = UNIT) -> LinearDelay:
    """Return the coefficients of a scalar equation with y eliminated, at states of size `scale`."""
    plain, none = view.without_y(), np.zeros((0, 3))
    x, v = scale * np.array([[[0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]]])
    f = np.broadcast_to(plain.drift(0.0, x, v, none), (1, 3))[0]
    g = np.broadcast_to(plain.diffusion(0.0, x, v, none), (1, 1, 3))[0, 0]
    (A, B), (c, d) = ((values[1:] - values[0]) / scale for values in (f, g))
    return LinearDelay(float(A), float(B), float(c), float(d), view.delay)


def is_scalar(view: Delayed) -> bool:
    """Return whether x and the noise are scalar, so that `linear_delay` describes the whole equation."""
    return view.dimension == view.noise_dim == 1


def at_rest(view: Delayed) -> bool:
    """Return whether zero is a solution of the equation with y eliminated."""
    plain, zero, none = view.without_y(), np.zeros((view.dimension, 1)), np.zeros((0, 1))
    return not any(np.any(part(0.0, zero, zero, none)) for part in (plain.drift, plain.diffusion))


def is_autonomous(view: Delayed) -> bool:
    """Return whether drift and diffusion with y eliminated have the same values at two times."""
    plain, none = view.without_y(), np.zeros((0, 4))
    x, v = np.random.Generator(np.random.Philox(key=SEED + 6)).standard_normal((2, view.dimension, 4))
    later = WHEN * view.horizon
    return all(
        np.allclose(part(0.0, x, v, none), part(later, x, v, none), rtol=1e-12, atol=0.0)
        for part in (plain.drift, plain.diffusion)
    )
