"""The spectral radius of a delayed step's second moments, at the cost of a sparse system of the delay's length.

The radius r is the least number that is above the squares of all eigenvalues without noise, counted by the argument
principle, and at which the gain of the noise is at most 1. No matrix of the history's second moments is made.
"""

import numpy as np
from scipy.optimize import brentq

from ...forms import Mesh
from ..linear.delay_step import Lagged, LinearDelayStep, lagged
from .delay_covariances import noise_gain
from .delay_zeros import outside
from .spectral import WIDTHS, SpectralRadius

# Gains are decided if they differ from 1 by so many times their error.
ERRORS = 10.0
# Powers of r that are used stay below this.
LARGEST_POWER = 1e200
LARGEST_RADIUS = 1e30
# Rows of a companion matrix whose eigenvalues are looked for, what rounding leaves of no noise, and the width that is
# enough, relative to the radius.
DENSE, NEGLIGIBLE, CERTAIN = 256, 1e-12, 1e-10
# Widths about 1 that a decision tries, up to 1e-9.
CLOSE = 4


def is_stable(step: LinearDelayStep, mesh: Mesh) -> bool | None:
    """Tell whether second moments tend to 0; None if the arithmetic does not tell."""
    if not np.isfinite(step.maps).all():
        return None
    recursion = lagged(step, mesh)
    side = _side(recursion, 1.0)
    # On the circle itself an eigenvalue of the means may lie, while noise makes the radius larger.
    beside = (d for width in WIDTHS[:CLOSE] for d in (width, -width))
    while side == 0 and (d := next(beside, 0.0)):
        found = _side(recursion, 1.0 + d)
        side = found if found * d < 0.0 else 0
    return {1: True, 0: None, -1: False}[side]


def radius(step: LinearDelayStep, mesh: Mesh) -> SpectralRadius:
    """Return the spectral radius of the second moments of the whole history.

    Parameters
    ----------
    step : LinearDelayStep
    mesh : Mesh

    Returns
    -------
    SpectralRadius
        Its width is a distance at which both sides are decided, as `is_stable` decides at 1. Radii so small that
        their power m + 1 is below 1e-200 are only bounded.
    """
    if not np.isfinite(step.maps).all():
        return SpectralRadius(np.inf, np.inf)
    recursion = lagged(step, mesh)
    floor = LARGEST_POWER ** (-1.0 / (recursion.lags[-1] + 1.0))
    if (found := _without_noise(recursion, floor)) is not None:
        return found
    low, high = _bracket(recursion, floor)
    if high >= LARGEST_RADIUS:
        return SpectralRadius(np.inf, np.inf)
    if low <= floor and _excess(recursion, floor) > 0.0:
        return SpectralRadius(0.5 * floor, 0.5 * floor)
    logarithm = brentq(
        lambda s: _excess(recursion, float(np.exp(s))), np.log(low), np.log(high), xtol=1e-15, rtol=1e-15
    )
    rho = float(np.exp(logarithm))
    return SpectralRadius(rho, _width(recursion, rho))


def _without_noise(recursion: Lagged, floor: float) -> SpectralRadius | None:
    """Return the largest squared eigenvalue of the companion matrix where it is certain and noise does not act.

    Bisection, which has no slope to go by without noise, takes fifty counts of eigenvalues.
    """
    count, k = int(recursion.lags[-1]) + 1, recursion.maps.shape[-1]
    if np.abs(recursion.maps[1:]).max(initial=0.0) > NEGLIGIBLE or count * k > DENSE:
        return None
    F = np.eye(count * k, k=-k)
    for lag, part in zip(recursion.lags, recursion.maps[0], strict=True):
        F[:k, lag * k : (lag + 1) * k] = part
    rho = float(np.abs(np.linalg.eigvals(F)).max() ** 2)
    found = SpectralRadius(rho, _width(recursion, rho) if rho > floor else np.inf)
    return found if found.width <= CERTAIN * rho else None


def mean_radius(step: LinearDelayStep, mesh: Mesh) -> SpectralRadius:
    """Return the spectral radius of the step without noise, which carries the means."""
    rho, width = radius(LinearDelayStep(step.drift, step.noise[:0]), mesh)
    root = float(np.sqrt(rho))
    return SpectralRadius(root, width / root)


def _excess(recursion: Lagged, r: float) -> float:
    # Negative below the radius, positive above, and nearly linear where noise makes the radius.
    if outside(recursion, float(np.sqrt(r))) != 0:
        return -1.0
    gain = noise_gain(recursion, r).value
    return 1.0 / gain - 1.0 if gain > 0.5 else 1.0


def _side(recursion: Lagged, r: float) -> int:
    # 1 if r is above the radius, -1 if it is below, 0 if that is not certain.
    count = outside(recursion, float(np.sqrt(r)))
    if count != 0:
        return 0 if count is None else -1
    gain, error = noise_gain(recursion, r)
    return 0 if abs(gain - 1.0) <= ERRORS * error else int(np.sign(1.0 - gain))


def _bracket(recursion: Lagged, floor: float) -> tuple[float, float]:
    # Steps that grow from the scale of one delay: far below the radius, many eigenvalues have to be counted.
    below = _excess(recursion, 1.0) <= 0.0
    low, high, step = 1.0, 1.0, 1.0 / (recursion.lags[-1] + 1.0)
    while (below and low == high) or (below and high < LARGEST_RADIUS and _excess(recursion, high) <= 0.0):
        low, high, step = high, high * np.exp(step), 2.0 * step
    while not below and (low == high or (low > floor and _excess(recursion, low) > 0.0)):
        low, high, step = max(floor, low * np.exp(-step)), low, 2.0 * step
    return low, high


def _width(recursion: Lagged, rho: float) -> float:
    for width in WIDTHS:
        d = width * rho
        if _side(recursion, rho + d) > 0 and _side(recursion, rho - d) < 0:
            return d
    return np.inf
