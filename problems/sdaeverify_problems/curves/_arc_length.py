"""The ellipse x = 2 cos theta, y = sin theta by arc length s, ds = l(theta) dtheta, l^2 = 1 + 3 sin^2 theta."""

from functools import cache

import numpy as np
import scipy

from sdaeverify import Array, Increment, Parts, Pathwise
from sdaeverify.numerics import directional

from .._known import solution

# l is between 1 and 2, and Newton's method for s(theta) = s converges quadratically from its start, less than 0.2
# away.
NEWTON_STEPS = 6


@cache
def circumference() -> float:
    """Return the length of the ellipse, 4 E(-3)."""
    return 4.0 * float(scipy.special.ellipe(-3.0))


def speed(theta: Array) -> Array:
    """Return l = ds/dtheta, shape of theta."""
    return np.sqrt(1.0 + 3.0 * np.sin(theta) ** 2)


def angle(s: Array) -> Array:
    """Return theta(s), by Newton's method starting at the angle on a circle of the same circumference."""
    theta = 2 * np.pi / circumference() * s
    for _ in range(NEWTON_STEPS):
        theta = theta - (scipy.special.ellipeinc(theta, -3.0) - s) / speed(theta)
    return theta


def drift(theta: Array) -> Array:
    """Return the drift beta = -(1/2) d log l/ds = -(3/4) sin 2 theta/l^3 of s, reversible for ds/l."""
    return -0.75 * np.sin(2 * theta) / speed(theta) ** 3


def slope(theta: Array) -> Array:
    """Return dbeta/ds = (-(3/2) cos 2 theta + (27/8) sin^2 2 theta/l^2)/l^4."""
    square = speed(theta) ** 2
    return (3.375 * np.sin(2 * theta) ** 2 / square - 1.5 * np.cos(2 * theta)) / square**2


def taylor(s: Array, t: float, h: float, noise: Increment) -> Array:
    """Return s after one Ito-Taylor step of strong order 3/2 of ds = beta dt + dW, shape (1, P)."""
    theta = angle(s)
    beta, first = drift(theta), slope(theta)
    second = directional(slope, theta, np.ones_like(theta)) / speed(theta)
    curved = 0.5 * h * h * (beta * first + 0.5 * second)
    return s + beta * h + noise.dW + first * noise.time_integral(h) + curved


def arc_truth(theta_0: float, fixman: float) -> Pathwise:
    """Return the solution by arc length: Brownian motion, or with the drift of delta(g) if `fixman` is not 0."""
    s_0 = float(scipy.special.ellipeinc(theta_0, -3.0))

    def parts(t: float, s: Array) -> Parts:
        theta = angle(s)
        return {"x": np.concatenate([2.0 * np.cos(theta), np.sin(theta)])}

    if fixman:
        return solution(s_0, taylor, "order 3/2 in the arc length", parts=parts, order=1.5)
    return solution(s_0, lambda s, t, h, noise: s + noise.dW, "arc length s_0 + W", parts=parts)
