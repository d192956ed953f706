"""Moments of penalised dynamics near the unit sphere of R^d with f = -damping x + S x, S^T = -S, started on it.

With zeta = (|x|^2 - 1)/2, Y = |X|^2 is a process of Cox, Ingersoll and Ross, and the mean of a harmonic polynomial p
of degree l is

    E p(X_t) = p(e^{St} X_0) E[ Y_t^{l/2} exp( -(sigma^2/2) l (l + d - 2) int_0^t ds/Y_s ) ].
"""

from typing import NamedTuple

import numpy as np
import scipy

# Trapezoidal rule in log u for an integrand that is analytic for |Im log u| < pi/2: error e^{-2 pi 1.3/0.2}.
LOGARITHMS = np.arange(-45.0, 45.0, 0.2)


class RadialLaw(NamedTuple):
    """Law of the distance from the centre.

    Attributes
    ----------
    eps : float
        Stiffness parameter, not negative; 0 for the constrained dynamics.
    d : int
    sigma : float
        Positive.
    damping : float
        Not negative.
    """

    eps: float
    d: int
    sigma: float
    damping: float = 0.0

    @property
    def rate(self) -> float:
        """Rate b = 2 damping + 1/eps in dY = (a - bY) dt + 2 sigma sqrt(Y) dB."""
        return 2.0 * self.damping + 1.0 / self.eps

    @property
    def level(self) -> float:
        """Invariant mean E Y = a/b with a = sigma^2 (d + 1) + 1/eps."""
        if self.eps == 0.0:
            return 1.0
        return 1.0 + (self.sigma**2 * (self.d + 1) - 2.0 * self.damping) / self.rate

    def square(self, t: float = np.inf) -> float:
        """Return E Y_t."""
        return 1.0 if self.eps == 0.0 else float(1.0 - (self.level - 1.0) * np.expm1(-self.rate * t))

    def fourth(self, t: float = np.inf) -> float:
        """Return E Y_t^2, with Var Y_t = (2 sigma^2/b) (1 - e) (2 e + (a/b) (1 - e)) and e = e^{-bt}.

        The value overflows to infinity for very large eps without damping.
        """
        if self.eps == 0.0:
            return 1.0
        gone = -np.expm1(-self.rate * t)
        with np.errstate(over="ignore"):
            variance = 2.0 * self.sigma**2 / self.rate * gone * (2.0 * (1.0 - gone) + self.level * gone)
            return float(np.square(self.square(t)) + variance)

    def harmonic(self, degree: int, t: float) -> float:
        """Return the factor E p(X_t)/p(e^{St} X_0) of a harmonic polynomial p of degree 1 or 2.

        With delta = a/sigma^2 and alpha (delta + alpha - 2) = l (l + d - 2) the factor is e^{-alpha b t/2} E' Y_t^s,
        where s = (l - alpha)/2 is between 0 and 1 and Y_t = v chi'^2 with delta + 2 alpha degrees of freedom and
        noncentrality e^{-bt}/v, v = sigma^2 (1 - e^{-bt})/b. For M(u) = E' e^{-uY_t} and m = E' Y_t,

            E' Y_t^s = m^s - (s/Gamma(1 - s)) int_0^inf (M(u) - e^{-um}) u^{-s-1} du.
        """
        eigenvalue = degree * (degree + self.d - 2.0)
        if self.eps == 0.0:
            return float(np.exp(-0.5 * self.sigma**2 * eigenvalue * t))
        b, v = self.rate, -(self.sigma**2) * np.expm1(-self.rate * t) / self.rate
        delta = self.d + 1.0 + 1.0 / (self.sigma**2 * self.eps)
        alpha = _exponent(delta, eigenvalue)
        s, freedom, rest = 0.5 * (degree - alpha), delta + 2.0 * alpha, np.exp(-b * t)
        m = v * freedom + rest
        u = np.exp(LOGARITHMS) / m
        transform = np.expm1(-0.5 * freedom * np.log1p(2.0 * u * v) - u * rest / (1.0 + 2.0 * u * v))
        lacking = 0.2 * ((transform - np.expm1(-u * m)) @ u**-s) * s / scipy.special.gamma(1.0 - s)
        return float(np.exp(-0.5 * alpha * b * t) * (m**s - lacking))

    @property
    def relaxation(self) -> float:
        """Time in which harmonic polynomials of degree 1, the slowest of all functions, decay by a factor e."""
        if self.eps == 0.0:
            return 2.0 / (self.sigma**2 * (self.d - 1.0))
        delta = self.d + 1.0 + 1.0 / (self.sigma**2 * self.eps)
        return 2.0 / (_exponent(delta, self.d - 1.0) * self.rate)


def _exponent(delta: float, eigenvalue: float) -> float:
    """Return the positive root of alpha (delta + alpha - 2) = eigenvalue, by a formula without cancellation."""
    return float(2.0 * eigenvalue / (delta - 2.0 + np.hypot(delta - 2.0, 2.0 * np.sqrt(eigenvalue))))
