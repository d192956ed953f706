"""Long-time behaviour of the deterministic equation r' = A r + B r(t - tau), Hayes (1950), Kuchler & Mensch (1992).

With w^2 = A^2 - B^2, K(0) = int_0^inf r(t)^2 dt and K(tau) = int_0^inf r(t) r(t - tau) dt are

    K(0) = (B sh - 1)/(2 (A + B ch)),   K(tau) = -(ch + A sh)/(2 (A + B ch)),   ch = cosh(w tau), sh = sinh(w tau)/w,

or equivalently, with beta = B/(w - A) and E = e^(-w tau),

    K(0) = (1 + E beta)/(2 w (1 - E beta)),   K(tau) = (E + beta)/(2 w (1 - E beta)).
"""

from cmath import cosh, exp, sinh, sqrt
from typing import NamedTuple

import numpy as np

from sdaeverify.numerics import lambert_of_log

from ._scalar_delay import ScalarDelay


class Covariances(NamedTuple):
    """The integrals K(0) and K(tau)."""

    now: float
    lagged: float


def rate(equation: ScalarDelay) -> float:
    """Return the largest real part of a root of s = A + B e^(-s tau); r decays exactly if it is negative.

    The value is A + W_0(z)/tau with z = B tau e^(-A tau).
    """
    A, B, tau = equation.A, equation.B, equation.tau
    if B == 0.0:
        return A
    logarithm = np.log(abs(B) * tau) - A * tau
    return float(A + lambert_of_log(logarithm, B < 0.0).real / tau)


def covariances(equation: ScalarDelay) -> Covariances:
    """Return K(0) and K(tau); the formulas hold only if r decays."""
    A, B, tau = equation.A, equation.B, equation.tau
    w = sqrt(A * A - B * B)
    # The second form suffers from cancellation near w = 0, the first one for B > 0; the first one overflows for large
    # w.
    if B > 0.0 or (w * tau).real > 1.0:
        beta, E = B / (w - A), exp(-w * tau)
        scale = 2.0 * w * (1.0 - E * beta)
        return Covariances(((1.0 + E * beta) / scale).real, ((E + beta) / scale).real)
    ch, sh = cosh(w * tau), sinh(w * tau) / w if w else tau
    scale = 2.0 * (A + B * ch)
    return Covariances(((B * sh - 1.0) / scale).real, (-(ch + A * sh) / scale).real)


def mean_square_stable(equation: ScalarDelay) -> bool:
    """Return whether E x^2 tends to 0 without additive noise: int_0^inf (c r(t) + d r(t - tau))^2 dt < 1."""
    if rate(equation) >= 0.0:
        return False
    c, d, (now, lagged) = equation.c, equation.d, covariances(equation)
    return bool((c * c + d * d) * now + 2.0 * c * d * lagged < 1.0)
