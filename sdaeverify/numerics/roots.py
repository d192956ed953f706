"""Roots of functions of one variable, by Brent's method.

Step by step as `scipy.optimize.brentq` takes it, to the last bit: that takes each worker process longer to load than
all that scipy is used for beside.
"""

from collections.abc import Callable
from math import copysign, inf, isnan
from typing import NamedTuple

# As many as scipy allows.
STEPS = 100


class _Point(NamedTuple):
    """A place, and the value there."""

    x: float
    y: float

    def opposes(self, other: "_Point") -> bool:
        """Tell whether there is a root between."""
        return 0.0 not in {self.y, other.y} and (self.y < 0.0) != (other.y < 0.0)


def _evaluate(function: Callable[[float], float], x: float) -> _Point:
    y = float(function(x))
    if isnan(y):
        raise ValueError(f"the value at {x:.6g} is not a number")
    return _Point(x, y)


def find_root(function: Callable[[float], float], low: float, high: float, *, xtol: float, rtol: float) -> float:
    """Return a root between two places, at which the values have opposite signs unless one is 0.

    Parameters
    ----------
    function : callable, float -> float
    low, high : float
    xtol, rtol : float
        How far the place may be off, beside half of that in units of its size.

    Raises
    ------
    ValueError
        If the values have the same sign, or one is not a number.
    ArithmeticError
        If the root is not found.
    """
    before, now = (_evaluate(function, float(x)) for x in (low, high))
    if 0.0 in {before.y, now.y}:
        return before.x if before.y == 0.0 else now.x
    if not before.opposes(now):
        raise ValueError("the values at both ends have the same sign")
    across, last, step = before, 0.0, 0.0
    for _ in range(STEPS):
        if before.opposes(now):
            across, last, step = before, now.x - before.x, now.x - before.x
        if abs(across.y) < abs(now.y):
            before, now, across = now, across, now
        least, half = 0.5 * (xtol + rtol * abs(now.x)), 0.5 * (across.x - now.x)
        if now.y == 0.0 or abs(half) < least:
            return now.x
        falls = abs(last) > least and abs(now.y) < abs(before.y)
        guess = _interpolate(before, now, across) if falls else inf
        trusted = 2.0 * abs(guess) < min(abs(last), 3.0 * abs(half) - least)
        last, step = (step, guess) if trusted else (half, half)
        x = now.x + (step if abs(step) > least else copysign(least, half))
        before, now = now, _evaluate(function, x)
    raise ArithmeticError(f"no root is found in {STEPS} steps")


def _interpolate(before: _Point, now: _Point, across: _Point) -> float:
    """Return how far the root is, by a line through two points, or by an inverse parabola through three."""
    if before.x == across.x:
        return -now.y * (now.x - before.x) / (now.y - before.y)
    first, second = (before.y - now.y) / (before.x - now.x), (across.y - now.y) / (across.x - now.x)
    slopes = second * first * (across.y - before.y)
    return -now.y * (across.y * second - before.y * first) / slopes if slopes else inf
