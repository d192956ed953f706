"""A scalar linear delay equation with an affine past: its fundamental solution and its mean.

dx = (A x + B v) dt + (c x + d v + s) dW,    v(t) = x(t - tau),    x(t) = x_0 + slope t for t <= 0.
"""

from functools import cache
from math import ceil, factorial, floor
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from sdaeverify import Array

# Points that resolve a piece on which rates are small; two more for each unit of rate times delay.
POINTS = 32


class ScalarDelay(NamedTuple):
    """The coefficients, per unit of time or its square root, the delay, and the past.

    Attributes
    ----------
    A, B, c, d, s : float
    tau : float
        Positive.
    x_0, slope : float
    """

    A: float
    B: float
    c: float
    d: float
    s: float
    tau: float
    x_0: float
    slope: float

    def past(self, t: float) -> list[float]:
        """Return the history at t <= 0."""
        return [self.x_0 + self.slope * t]

    def decay(self, k: int, u: Array) -> Array:
        """Return r(k tau + u), that is sum_j (B (t - j tau))^j/j! e^(A (t - j tau)); 0 for k < 0."""
        ages = [(k - j) * self.tau + u for j in range(k + 1)]
        terms = ((self.B * age) ** j / factorial(j) * np.exp(self.A * age) for j, age in enumerate(ages))
        return np.asarray(sum(terms, np.zeros_like(u)))

    def square(self, k: int, u: Array) -> Array:
        """Return r^2 there."""
        return self.decay(k, u) ** 2

    def kernel(self, k: int, u: Array) -> Array:
        """Return (c r(t) + d r(t - tau))^2 there."""
        return np.asarray((self.c * self.decay(k, u) + self.d * self.decay(k - 1, u)) ** 2)

    @property
    def points(self) -> int:
        """Number of points that resolve the moments between two multiples of the delay."""
        return POINTS + 2 * ceil((abs(self.A) + self.c**2) * self.tau)


def piece(equation: ScalarDelay, t: float) -> tuple[int, float]:
    """Return how many delays fit into t, and what is left."""
    k = floor(t / equation.tau)
    return k, t - k * equation.tau


@cache
def mean(equation: ScalarDelay, k: int, u: float) -> float:
    """Return m(k tau + u): (1, u, m_0(u), ..., m_k(u)) obeys a linear equation, m_j(0) being m_{j-1}(tau)."""
    A, B, tau = equation.A, equation.B, equation.tau
    if k < 0:
        return equation.past(u - tau)[0]
    L = np.diag([0.0, 0.0, *[A] * (k + 1)]) + np.diag([0.0, 0.0, *[B] * k], -1)
    L[1, 0], L[2, :2] = 1.0, [B * (equation.x_0 - equation.slope * tau), B * equation.slope]
    start = [1.0, 0.0, *(mean(equation, j - 1, tau) for j in range(k + 1))]
    return float((expm(L * u) @ start)[-1])
