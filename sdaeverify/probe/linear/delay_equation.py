"""Delay equations that are linear, found by evaluating them, and the exact mean-square stability of a scalar one.

    dx = (A x + B x(t - tau)) dt + (c x + d x(t - tau)) dW,     r' = A r + B r(t - tau), r(0) = 1, r = 0 before 0.

E x^2 tends to 0 exactly if the roots of s = A + B e^(-s tau) have negative real parts and the integral of
(c r(t) + d r(t - tau))^2 over t > 0 is below 1. With K(a) the integral of r(t) r(t - a), it is

    (c^2 + d^2) K(0) + 2 c d K(tau),   K(0) = (B sh - 1)/(2 (A + B ch)),   K(tau) = -(ch + A sh)/(2 (A + B ch)),

ch = cosh(w tau), sh = sinh(w tau)/w, w^2 = A^2 - B^2. Numerators and denominator have a common zero, and overflow.
For A <= -|B|, with beta = B/(w - A) and E = e^(-w tau), they are the same as

    K(0) = (1 + E beta)/(2 w (1 - E beta)),   K(tau) = (E + beta)/(2 w (1 - E beta)),

and for B < -|A|, with w^2 = B^2 - A^2, psi = arg(-A + i w) and the slack s = pi - psi - w tau, positive exactly if
r decays,

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
# Rounding of a handful of operations, and of the slack per unit of its two terms.
# Rounding: EPS for each operation.
ROUNDING = 32.0 * EPS
# e^CLIP can be squared.
# Rounding: e^600 is less than the largest number, e^709.
CLIP = 300.0
# Sizes of the states: in a unit of the problem's own, and small and large enough for either limit.
UNIT, SMALL, LARGE = 1.0, 1e-12, 1e14


class LinearDelay(NamedTuple):
    """The coefficients of dx = (A x + B x(t - tau)) dt + (c x + d x(t - tau)) dW.

    Attributes
    ----------
    A, B : float
        Per unit of time.
    c, d : float
        Per square root of a unit of time.
    tau : float
        Delay, not negative.
    """

    A: float
    B: float
    c: float
    d: float
    tau: float

    @property
    def rightmost_root(self) -> complex:
        """The root of s = A + B e^(-s tau) with the largest real part, A + W_0(B tau e^(-A tau))/tau."""
        if self.tau == 0.0 or self.B == 0.0:
            return complex(self.A + (self.B if self.tau == 0.0 else 0.0))
        logarithm = float(np.log(abs(self.B) * self.tau) - self.A * self.tau)
        return complex(self.A + lambert_of_log(logarithm, self.B < 0.0) / self.tau)

    @property
    def mean_decays(self) -> bool | None:
        """Whether all roots have negative real parts; None if rounding does not tell (Hayes 1950)."""
        if self.A + self.B >= 0.0:
            return False
        if self.A <= self.B:
            return True
        slack, error = self._slack
        return None if abs(slack) <= error else slack > 0.0

    @property
    def covariances(self) -> tuple[float, float]:
        """The integrals K(0) of r(t)^2 and K(tau) of r(t) r(t - tau); infinite unless r decays for certain."""
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
        """The integral of (c r(t) + d r(t - tau))^2; infinite unless r decays for certain."""
        at_0, at_tau = self.covariances
        if at_0 == np.inf:
            return np.inf
        return float((self.c**2 + self.d**2) * at_0 + 2.0 * self.c * self.d * at_tau)

    @property
    def noise_integral_error(self) -> float:
        """A bound of what rounding does to the integral: relative to its terms, |K(tau)| being at most K(0)."""
        relative = ROUNDING
        if self.A > self.B:
            slack, error = self._slack
            relative += 2.0 * error / abs(slack)
        return float(relative * (abs(self.c) + abs(self.d)) ** 2 * self.covariances[0])

    @property
    def stable(self) -> bool | None:
        """Whether E x^2 tends to 0; None if rounding does not tell."""
        if not self.mean_decays:
            return self.mean_decays
        integral, error = self.noise_integral, self.noise_integral_error
        return None if abs(integral - 1.0) <= error else integral < 1.0

    @property
    def growth_rate(self) -> float:
        """The rate lam of E x^2 ~ e^(lam t), per unit of time.

        It is where the integral of e^(-lam t) (c r(t) + d r(t - tau))^2 is 1, that is the integral of the equation
        `discount` by lam, or twice the real part of the rightmost root if that is larger. The integral decreases in
        lam; its reciprocal is 0 at the latter, and nearly a straight line.
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
        """Return the equation of e^(-rate t/2) x."""
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
        # Negative below the growth rate, positive above.
        if rate <= 2.0 * self.rightmost_root.real:
            return -1.0
        integral = self.discount(rate).noise_integral
        return 1.0 / integral - 1.0 if integral > 0.5 else 1.0


def _hyperbolic(w: float, u: float, psi: float, opposed: bool) -> tuple[float, float]:
    # E = e^(-u) and |beta| = e^(-psi); differences are taken in the exponents.
    product, gap = np.exp(-u - psi), -np.expm1(-u - psi)
    if opposed:
        difference = np.sign(psi - u) * np.exp(-min(u, psi)) * -np.expm1(-abs(psi - u))
        return float(gap / (2.0 * w * (1.0 + product))), float(difference / (2.0 * w * (1.0 + product)))
    return float((1.0 + product) / (2.0 * w * gap)), float((np.exp(-u) + np.exp(-psi)) / (2.0 * w * gap))


def linear_delay(view: Delayed, scale: float = UNIT) -> LinearDelay:
    """Return the coefficients of the equation with y eliminated, at states of some size; it is scalar."""
    plain, none = view.without_y(), np.zeros((0, 3))
    x, v = scale * np.array([[[0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]]])
    f = np.broadcast_to(plain.drift(0.0, x, v, none), (1, 3))[0]
    g = np.broadcast_to(plain.diffusion(0.0, x, v, none), (1, 1, 3))[0, 0]
    (A, B), (c, d) = ((values[1:] - values[0]) / scale for values in (f, g))
    return LinearDelay(float(A), float(B), float(c), float(d), view.delay)


def is_scalar(view: Delayed) -> bool:
    """Tell whether x and the noise have one dimension, so that `linear_delay` says all of the equation."""
    return view.dimension == view.noise_dim == 1


def at_rest(view: Delayed) -> bool:
    """Tell whether zero is a solution of the equation with y eliminated."""
    plain, zero, none = view.without_y(), np.zeros((view.dimension, 1)), np.zeros((0, 1))
    return not any(np.any(part(0.0, zero, zero, none)) for part in (plain.drift, plain.diffusion))


def is_autonomous(view: Delayed) -> bool:
    """Tell whether drift and diffusion with y eliminated are the same at two times."""
    plain, none = view.without_y(), np.zeros((0, 4))
    x, v = np.random.Generator(np.random.Philox(key=SEED + 6)).standard_normal((2, view.dimension, 4))
    later = WHEN * view.horizon
    return all(
        np.allclose(part(0.0, x, v, none), part(later, x, v, none), rtol=1e-12, atol=0.0)
        for part in (plain.drift, plain.diffusion)
    )
