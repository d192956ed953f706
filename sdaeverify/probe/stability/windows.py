"""Windows of step sizes on which a scheme is stable: log rho on a grid, with sign changes by Brent's method.

The set need not be an interval. Between two neighbours of the grid with the same sign there may be an undetected
window or gap if |log rho| can reach 0 there at `STEEPER` times the steepest adjacent slope. Such intervals are
halved, as in Piyavskii's method of finding extrema, until the ratio of neighbours is `NARROW`. Narrower or steeper
ones are not detected.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from ...arrays import Array
from ...numerics.roots import log_root

# Smallest |rho - 1| that decides, absolute and as a multiple of its error.
# Rounding: an operator that two rules give to 1e-12 has a radius that is known to 1e-9 if its condition is 1000.
MARGIN, ERRORS = 1e-9, 10.0
# Size: of a search; what is narrower or steeper is not detected.
STEEPER, NARROW = 4.0, 1.001
# log rho if rho overflows, or minus this if it is 0.
# Rounding: e^709 is the largest number.
LARGEST = 700.0

Window = tuple[float, float]


def signs(rho: Array, error: Array) -> Array:
    """Return -1 where rho is below 1, +1 where it is above, 0 where neither is certain (marginal)."""
    margin = np.maximum(MARGIN, ERRORS * error)
    decided = np.abs(rho - 1.0) > margin
    return np.where(decided, np.where(rho < 1.0, -1, 1), 0)


def brackets(sign: Array) -> list[tuple[int, int]]:
    """Return the pairs of indices between which the sign changes, with at most one undecided index between them."""
    decided = np.flatnonzero(sign)
    return [(int(i), int(j)) for i, j in pairwise(decided) if sign[i] != sign[j] and j - i <= 2]


def crossings(radius: Callable[[float], float], h: Array, sign: Array) -> Array:
    """Return the step sizes at which rho crosses 1, ascending.

    Parameters
    ----------
    radius : callable, h -> rho
    h : ndarray, shape (S,)
        Grid, ascending.
    sign : ndarray, shape (S,)
        Sign of rho - 1 on the grid, 0 where undecided.

    Returns
    -------
    ndarray, shape (C,)
    """

    def log_rho(size: float) -> float:
        with np.errstate(divide="ignore"):
            value = np.log(radius(size))
        return LARGEST if np.isnan(value) else float(np.clip(value, -LARGEST, LARGEST))

    return np.array([log_root(log_rho, float(h[i]), float(h[j])) for i, j in brackets(sign)])


def doubtful(h: Array, rho: Array, sign: Array) -> Array:
    """Return the midpoints of grid intervals in which rho may cross 1 and return.

    Parameters
    ----------
    h, rho, sign : ndarray, shape (S,)
        As for `crossings`.

    Returns
    -------
    ndarray, shape (D,)
        Geometric means, ascending.
    """
    with np.errstate(divide="ignore"):
        value = np.log(rho)
    width = np.diff(np.log(h))
    with np.errstate(invalid="ignore"):
        change = np.abs(np.diff(value))
    # Differences to 0, infinity or NaN give no slope.
    slope = np.pad(np.where(np.isfinite(change), change, 0.0) / width, 1, mode="edge")
    steepest = np.maximum(np.maximum(slope[:-2], slope[1:-1]), slope[2:])
    within_reach = np.abs(value[1:]) + np.abs(value[:-1]) < STEEPER * steepest * width
    hidden = (sign[1:] * sign[:-1] > 0) & within_reach & (width > np.log(NARROW))
    return np.asarray(np.sqrt(h[1:] * h[:-1])[hidden])


def stable_windows(h: Array, sign: Array, boundaries: Array) -> list[Window]:
    """Return the intervals of step sizes on which rho < 1, as far as decided.

    Parameters
    ----------
    h, sign : ndarray, shape (S,)
        As for `crossings`.
    boundaries : ndarray, shape (C,)
        The crossings.

    Returns
    -------
    list of (low, high)
        A window that begins with the grid has low = 0, one that reaches its end has high = infinity. Next to
        undecided grid points, a window ends with the last decided one.
    """
    ends = brackets(sign)
    after = {j: float(b) for (_, j), b in zip(ends, boundaries, strict=True)} | {0: 0.0}
    before = {i: float(b) for (i, _), b in zip(ends, boundaries, strict=True)} | {len(h) - 1: np.inf}
    stable = np.concatenate([[False], sign < 0, [False]])
    first, last = np.flatnonzero(~stable[:-1] & stable[1:]), np.flatnonzero(stable[:-1] & ~stable[1:]) - 1
    return [
        (after.get(int(i), float(h[i])), before.get(int(j), float(h[j]))) for i, j in zip(first, last, strict=True)
    ]


def find_undecided(sign: Array) -> Array:
    """Return the undecided indices, except single ones between opposite signs, which are crossings."""
    padded = np.concatenate([[0], sign, [0]])
    crossing = padded[:-2] * padded[2:] < 0
    return np.flatnonzero((sign == 0) & ~crossing)


def smallest_boundary(windows: list[Window]) -> float:
    """Return the step size below which all are stable: infinite if the only window has no end, 0 if none."""
    return windows[0][1] if windows and windows[0][0] == 0.0 else 0.0


def describe_windows(windows: list[Window]) -> str:
    """Describe windows in words: ``h < 0.5; 2 < h < 3``."""
    return "; ".join(_describe_window(low, high) for low, high in windows) or "none"


def _describe_window(low: float, high: float) -> str:
    if low == 0.0 and high == np.inf:
        return "all h"
    above = f"{low:.6g} < h" if low > 0.0 else "h"
    return f"{above} < {high:.6g}" if high < np.inf else f"h > {low:.6g}"
