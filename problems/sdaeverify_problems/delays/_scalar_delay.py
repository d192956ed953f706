"""A scalar linear delay equation with an affine history.

dx = (A x + B v) dt + (c x + d v + s) dW,    v(t) = x(t - tau),    x(t) = x_0 + slope t for t <= 0.
"""

from math import floor
from typing import NamedTuple

from sdaeverify import Array


class ScalarDelay(NamedTuple):
    """Coefficients, per unit of time or its square root, with the delay and the history.

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

    def past(self, t: Array) -> Array:
        """Return the history x_0 + slope t at times t <= 0."""
        return self.x_0 + self.slope * t


def piece(equation: ScalarDelay, t: float) -> tuple[int, float]:
    """Return the number of whole delays in t, and the remaining time."""
    k = floor(t / equation.tau)
    return k, t - k * equation.tau
