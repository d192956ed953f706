"""Truths on the exponential strip x = (t, n): the invariant law of n, and the exact solution in the limit eps = 0."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Moment, Parts, Pathwise, Truth

from .._known import limits, moments, solution
from ..ou import exponential_integral

SOURCE = "radial invariant density of n, quadrature"
EXACT = "Ornstein-Uhlenbeck process along the line n = 0"
# Trapezoidal rule in log |n| for an integrand that is analytic for |Im log |n|| < pi/4: error e^{-2 pi 0.7/0.1}.
STEP, LOWEST = 0.1, 45.0


class Strip(NamedTuple):
    """Parameters: dimension q of n, growth alpha of zeta = e^{alpha t} n, f = (-kappa (t - c), -kappa n).

    Attributes
    ----------
    eps : float
    q : int
    alpha, kappa, sigma, c : float
    start : float
        Value of the coordinate t at time 0.
    """

    eps: float
    q: int
    alpha: float
    kappa: float
    sigma: float
    c: float
    start: float = 0.0

    def radial_means(self, *functions: Callable[[Array], Array]) -> list[float]:
        """Return the means of functions of r = |n| under the invariant law, for eps > 0.

        The density of r is r^(q-1) exp(-kappa r^2/sigma^2) (1 + alpha^2 r^2)^(1/2 - 1/(sigma^2 eps alpha^2)).
        """
        a, s = self.alpha**2, self.sigma**2
        width = 1.0 / np.sqrt(self.kappa / s + 1.0 / (s * self.eps))
        highest = 4.0 + np.log(self.sigma / np.sqrt(self.kappa) / width)
        r = width * np.exp(np.arange(-LOWEST, highest, STEP))
        power = 0.5 - 1.0 / (s * self.eps * a)
        log = self.q * np.log(r / width) - self.kappa * r**2 / s + power * np.log1p(a * r**2)
        weights = np.exp(log - log.max())
        return [float(weights @ function(r) / weights.sum()) for function in functions]

    def invariant_means(self) -> dict[str, float]:
        """Return the means of t, |n|^2 and |n|^4 under the invariant law, or of t and t^2 in the limit.

        E t = c + (1/kappa) (sigma^2 q alpha/2 - (alpha/eps) E[ |n|^2/(1 + alpha^2 |n|^2) ]).
        """
        if self.eps == 0.0:
            return {"t": self.c, "t^2": self.c**2 + self.sigma**2 / (2.0 * self.kappa)}
        push, square, fourth = self.radial_means(
            lambda r: (r / (1.0 + self.alpha**2 * r**2)) * (r / self.eps), np.square, lambda r: r**4
        )
        drift = self.alpha * (0.5 * self.sigma**2 * self.q - push)
        return {"t": self.c + drift / self.kappa, "|n|^2": square, "|n|^4": fourth}

    def truths(self) -> tuple[Truth, ...]:
        """Return the invariant means, and for eps = 0 the pathwise solution and the moments."""
        source = SOURCE if self.eps else EXACT
        known = limits(self.invariant_means(), source)
        return (*known, *(() if self.eps else (self._pathwise(), *self._moments())))

    def _moments(self) -> tuple[Moment, ...]:
        def mean(t: float) -> float:
            return float(self.start - (self.start - self.c) * -np.expm1(-self.kappa * t))

        def square(t: float) -> float:
            return mean(t) ** 2 - self.sigma**2 / (2.0 * self.kappa) * float(np.expm1(-2.0 * self.kappa * t))

        return moments({"t": mean, "t^2": square}, EXACT)

    def _pathwise(self) -> Pathwise:
        def advance(t: Array, time: float, h: float, noise: Increment) -> Array:
            alpha, beta, rest = exponential_integral(self.kappa * h)
            integral = alpha * noise.dW[:1] + beta * noise.H[:1] + rest * np.sqrt(h) * noise.xi
            return np.asarray(t + np.expm1(-self.kappa * h) * (t - self.c) + self.sigma * integral)

        def parts_of(_: float, t: Array) -> Parts:
            return {"x": np.concatenate([t, np.zeros((self.q, t.shape[1]))])}

        return solution(self.start, advance, EXACT, parts=parts_of, extra_normals=1)


def observables(limit: bool) -> dict[str, Callable[[float, Parts], Array]]:
    """Return functions of t, and for eps > 0 of |n|, by name."""
    along = {"t": lambda t, s: s["x"][0], "t^2": lambda t, s: s["x"][0] ** 2}
    across = {
        "|n|^2": lambda t, s: (s["x"][1:] ** 2).sum(axis=0),
        "|n|^4": lambda t, s: (s["x"][1:] ** 2).sum(axis=0) ** 2,
    }
    return along if limit else along | across
