"""Orders of the errors of means, one for each observable, and which observables can tell one.

An error e(h) = c h^p + c' h^q, q > p, whose leading coefficient is small by accident changes its sign between two
step sizes, or has local orders that still move: it says nothing about the scheme, and is left out with a message.
An error that is not known well enough is not left out: it keeps the least order open.
"""

from collections.abc import Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..statistics import EPS
from .transition import ON_CHART
from .transition_errors import TransitionErrors

# An error is used where it is known to one digit.
ABOVE_FLOOR = 10.0
# An error is taken for none where so much of the observable's size would have been seen at the finest step sizes.
EXACT = 1e-6
# Local orders that differ by more are still on their way.
SETTLED = 0.3
NEEDED = 3
# Rounding of one application of the operator, in units of EPS and of the size of the observable.
ROUNDING = 64.0


class FunctionalOrder(NamedTuple):
    """What an observable says about the order.

    Attributes
    ----------
    order : float
        Local order at the finest usable step sizes, extrapolated to h = 0 where it has settled; infinite where no
        error is seen, NaN where none can be told.
    low, high : float
        What the order can be, the errors being known to `error_floors`; infinite where they are not known at all.
    informative : bool
        Whether a verdict may rest on it.
    resolved : bool
        False where it is not informative for want of accuracy: it could be the one that misses its order.
    coefficient : float
        c of e(h) = c h^order at the finest usable step size.
    note : str
    """

    order: float
    low: float
    high: float
    informative: bool = True
    resolved: bool = True
    coefficient: float = nan
    note: str = ""


def obstacle(record: TransitionErrors) -> str:
    """Return why the record is no evidence on the scheme, or an empty string."""
    worst = int(np.argmax(record.departure))
    if record.departure[worst] > ON_CHART:
        return f"the scheme leaves the chart, by {record.departure[worst]:.1g} at h = {record.h[worst]:.3g}"
    return ""


def functional_orders(record: TransitionErrors) -> tuple[FunctionalOrder, ...]:
    """Return what each observable says about the order.

    Parameters
    ----------
    record : TransitionErrors
        With step sizes from coarse to fine.

    Returns
    -------
    tuple of FunctionalOrder
    """
    columns = zip(record.errors.T, error_floors(record).T, _sizes(record), strict=True)
    return tuple(_order(record.h, errors, floors, size) for errors, floors, size in columns)


def least_order(orders: Sequence[FunctionalOrder]) -> tuple[float, float]:
    """Return the interval of the least order of all observables whose leading coefficient does not vanish.

    One that is not resolved leaves it open downwards; if there are none at all, nothing is known.
    """
    counted = [found for found in orders if found.informative or not found.resolved]
    return min((found.low for found in counted), default=-inf), min((found.high for found in counted), default=inf)


def error_floors(record: TransitionErrors) -> Array:
    """Return how far the errors can be off, shape (H, O).

    It is the difference of the two bases, rounding of all steps, and what failed and truncated steps can change:
    their number times the size of the observable; at this or a finer step size, whichever is most.
    """
    disturbed = record.steps * (record.failed + record.truncated + ROUNDING * EPS)
    floors = record.resolution + np.outer(disturbed, _sizes(record))
    return np.asarray(np.maximum.accumulate(floors[::-1])[::-1])


def _sizes(record: TransitionErrors) -> Array:
    return np.asarray(np.maximum(record.spread, np.abs(record.exact)))


def _order(h: Array, errors: Array, floors: Array, size: float) -> FunctionalOrder:
    with np.errstate(invalid="ignore"):
        usable = np.abs(errors) > ABOVE_FLOOR * floors
    if np.count_nonzero(usable) >= NEEDED:
        return _seen(h[usable], errors[usable], floors[usable])
    least = ABOVE_FLOOR * float(floors[-NEEDED:].max())
    if least <= EXACT * size and not usable[-NEEDED:].any():
        return FunctionalOrder(inf, inf, inf, note=f"no error beyond {least:.1g}")
    note = f"errors below {least:.1g} are not seen, and larger ones at fewer than {NEEDED} step sizes"
    return FunctionalOrder(nan, -inf, inf, informative=False, resolved=False, note=note)


def _seen(h: Array, errors: Array, floors: Array) -> FunctionalOrder:
    sizes, ratios = np.abs(errors), np.log(h[:-1] / h[1:])
    local = np.log(sizes[:-1] / sizes[1:]) / ratios
    # |log(e + f) - log e| <= -log(1 - f/e) for both signs of f.
    slack = -np.log1p(-floors / sizes)
    off = (slack[:-1] + slack[1:]) / ratios
    limit = local[-1] + (local[-1] - local[-2]) / np.expm1(ratios[-1])
    flips = np.flatnonzero(np.diff(np.sign(errors)))
    moving = abs(local[-1] - local[-2]) >= SETTLED
    if len(flips) and (moving or flips[-1] >= len(h) - NEEDED):
        where = f"between h = {h[flips[-1]]:.3g} and {h[flips[-1] + 1]:.3g}"
        return FunctionalOrder(nan, -inf, inf, informative=False, note=f"the error changes its sign {where}")
    order = float(local[-1] if moving else limit)
    low, high = sorted((order, float(limit)))
    spread = float(off[-1] + (off[-1] + off[-2]) / np.expm1(ratios[-1]))
    note = f"local orders {local[-2]:.2f}, {local[-1]:.2f} still move" if moving else ""
    coefficient = float(errors[-1] / h[-1] ** order)
    return FunctionalOrder(order, low - spread, high + spread, coefficient=coefficient, note=note)
