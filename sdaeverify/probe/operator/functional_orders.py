"""Orders of the errors of means, one for each observable, and which observables can tell one.

An error e(h) = c h^p + c' h^q, q > p, whose leading coefficient is small by accident changes its sign between two
step sizes, or has local orders that still move: it says nothing about the scheme, and is left out with a message.
Local orders that still rise have no upper bound: on steps too coarse for the problem they look low. So do those of a
scheme that finds next to nothing of a mean, or far too much of it. An error that stays behind those that fall is
found by extrapolation. An error that is not known well enough is not left out: it keeps the least order open.

A mean without any error tells nothing where equation and scheme share a symmetry that fixes it: it is as right for a
scheme with too much noise and too long steps.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Problem
from ...numerics.statistics import EPS, RISING
from ..step.one_step import STILL, why_not_resolved
from .transition import ON_CHART
from .transition_errors import TransitionErrors

# What an error leaves behind as h tends to 0: the coefficients of its lowest powers, by extrapolation.
#
# Of e(h) = c_0 + c_1 h + c_2 h^2 + ..., a small c_0 hardly changes the local orders at the step sizes used; so does a
# small c_1 beside c_2. Eliminating the next powers one after the other leaves c_0 (Romberg), and that of e(h)/h^q the
# coefficient of h^q where all lower ones vanish. What is left may belong to half powers: these are tried, too, and
# leave nothing of a coefficient that is not clear, or that they exclude.


# A coefficient differs from 0 if it is larger than this many times the bound of its error.
CLEAR = 10.0
FEWEST = 4


class Coefficient(NamedTuple):
    """The coefficient of the lowest power that does not vanish, or may not.

    Attributes
    ----------
    power : float
        q of c h^q, a whole number.
    value, known : float
        c, and how far it can be off.
    """

    power: float
    value: float
    known: float

    @property
    def clear(self) -> bool:
        """Whether c is told from 0."""
        return abs(self.value) > CLEAR * self.known


def lowest_power(h: Array, errors: Array, floors: Array, below: float) -> Coefficient | None:
    """Return the lowest power below a bound whose coefficient is not explained by what is known of it, or None.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, each half of the one before.
    errors, floors : ndarray, shape (H,)
        Errors with their signs, and how far they can be off.
    below : float

    Returns
    -------
    Coefficient or None
    """
    finite = np.isfinite(errors) & np.isfinite(floors)
    h, errors, floors = h[finite], errors[finite], floors[finite]
    if len(h) < FEWEST:
        return None
    found = (_coefficient(errors / h**power, floors / h**power, power) for power in np.arange(0.0, below))
    return next((each for each in found if each is not None), None)


def _coefficient(values: Array, floors: Array, power: float) -> Coefficient | None:
    whole = Coefficient(float(power), *_limit(values, floors, 1.0))
    if abs(whole.value) <= whole.known:
        return None
    half, known = _limit(values, floors, 0.5)
    vanishes, denies = abs(half) <= known, abs(half - whole.value) > known
    return None if vanishes and (denies or not whole.clear) else whole


def _limit(values: Array, floors: Array, step: float) -> tuple[float, float]:
    """Return the values extrapolated to h = 0, and how far that can be off.

    It is known to how far it changes without the finest step size, the coarsest or the two coarsest: the first
    predicts what the finest adds.
    """
    # Of a dozen numbers: lists take a third of the time of arrays.
    tables, blur = [values.tolist()], floors.tolist()
    for column in range(1, len(values)):
        ratio = 2.0 ** (step * column)
        tables.append([(ratio * fine - coarse) / (ratio - 1.0) for coarse, fine in pairwise(tables[-1])])
        blur = [(ratio * fine + coarse) / (ratio - 1.0) for coarse, fine in pairwise(blur)]
    (limit,), before = tables[-1], [*tables[-2], tables[-3][-1]]
    return limit, max(abs(each - limit) for each in before) + blur[0]


# An error is used where it is known to one digit, and held against a scheme where it is known to two: a local order
# is then off by less than 0.03.
ABOVE_FLOOR, FAR_ABOVE = 10.0, 100.0
# An error is taken for none where so much of the observable's size would have been seen at the finest step sizes.
EXACT = 1e-6
# Local orders that differ by more are still on their way.
SETTLED = 0.3
NEEDED = 3
# Where a scheme finds the mean times exp(-K h^p), its local orders are p (1 - K h^p/2 + ...): right to a tenth where
# its error is less than a tenth of the mean. Longer steps, which find nothing of the mean, show the order 0.
NEAR = 0.1
# Coefficients are asked for of powers that are lower than the order by more.
BETWEEN = 0.25
WRONG = "wrong limit"
# Rounding of one application of the operator, in units of EPS and of the size of the observable.
# Rounding: EPS for each operation.
ROUNDING = 64.0


class Fall(NamedTuple):
    """The mean order of an error between two step sizes.

    Attributes
    ----------
    most : float
        Upper bound of the order, the errors being known to their floors; infinite if there is none.
    coarse, fine : float
        The step sizes.
    """

    most: float = inf
    coarse: float = nan
    fine: float = nan


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
    fixed : bool
        True where it is not informative because a symmetry fixes the mean, or a step does not move.
    coefficient : float
        c of e(h) = c h^order at the finest usable step size.
    h : float
        The finest usable step size.
    note : str
    fall : Fall
        The slowest fall between two step sizes that the errors allow, also where too few are known for an order.
    """

    order: float
    low: float
    high: float
    informative: bool = True
    resolved: bool = True
    fixed: bool = False
    coefficient: float = nan
    h: float = nan
    note: str = ""
    fall: Fall = Fall()


def why_not_evidence(record: TransitionErrors) -> str:
    """Return that a scheme leaves the chart, so that the record is no evidence on it, or an empty string."""
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
    columns = zip(record.errors.T, error_floors(record).T, mean_sizes(record), record.response, strict=True)
    why = STILL if record.still else "a symmetry fixes its mean, which is right with too much noise as well"
    return tuple(
        _responsive(
            order_of(record.h, errors, floors, size), response > max(EXACT * size, ABOVE_FLOOR * floors[-1]), why
        )
        for errors, floors, size, response in columns
    )


def least_order(orders: Sequence[FunctionalOrder]) -> tuple[float, float]:
    """Return the interval of the least order of all observables whose leading coefficient does not vanish.

    One that is not resolved leaves it open downwards; if there are none at all, nothing is known.
    """
    counted = [found for found in orders if found.informative or not found.resolved]
    return min((found.low for found in counted), default=-inf), min((found.high for found in counted), default=inf)


def widen(orders: Sequence[FunctionalOrder], view: Problem) -> tuple[FunctionalOrder, ...]:
    """Return the orders without an upper bound where no step size that shows an error resolves the problem."""
    coarse = [why_not_resolved(view, found.h) if np.isfinite(found.h) else "" for found in orders]
    return tuple(
        found._replace(high=inf, note=_join_notes(found.note, why)) if why else found
        for found, why in zip(orders, coarse, strict=True)
    )


def error_floors(record: TransitionErrors) -> Array:
    """Return how far the errors can be off, shape (H, O).

    It is the difference of the two bases and what failed and truncated steps can change, their number times the size
    of the observable; the most of it at this and the next two finer step sizes: at one, bases may agree by chance.
    Rounding of all steps comes on top.
    """
    disturbed = record.steps * (record.failed + record.truncated)
    floors = record.resolution + np.outer(disturbed, mean_sizes(record))
    rounding = np.outer(ROUNDING * EPS * record.steps, mean_sizes(record))
    finer = np.pad(floors, [(0, NEEDED - 1), (0, 0)])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(finer, NEEDED, axis=0).max(axis=-1) + rounding)


def mean_sizes(record: TransitionErrors) -> Array:
    """Return the sizes of the observables, shape (O,): the larger of exact mean and root mean square."""
    return np.asarray(np.maximum(record.spread, np.abs(record.exact)))


def order_of(h: Array, errors: Array, floors: Array, size: float, exact: float = nan) -> FunctionalOrder:
    """Return what the errors of one mean say about its order.

    An order without upper bound is returned where the mean of the scheme has not come near a limit.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes from coarse to fine.
    errors, floors : ndarray, shape (H,)
        Errors with their signs, and how far they can be off.
    size : float
        Of what the mean is taken of.
    exact : float
        The mean of the solution; NaN where the order counts however far the scheme's mean is from its limit.

    Returns
    -------
    FunctionalOrder
    """
    found = _order_of_errors(h, errors, floors, size)._replace(fall=slowest_fall(h, errors, floors))
    used = h >= found.h
    if not _is_far(exact, errors[used], floors[used], size):
        return found
    note = f"the scheme's mean still changes at h = {found.h:.3g}, far from {exact:.2g}"
    return found._replace(high=inf, note=_join_notes(found.note, note))


def slowest_fall(h: Array, errors: Array, floors: Array) -> Fall:
    """Return the fall between two step sizes whose order has the least upper bound.

    Between h_i > h_j an error is at most of the order log((|e_i| + f_i)/(|e_j| - f_j)) / log(h_i/h_j). Pairs across a
    change of sign are left out, and pairs between which the local order rises: steps as coarse as h_i show too low an
    order then.

    Parameters
    ----------
    h, errors, floors : ndarray, shape (H,)
        Step sizes from coarse to fine, errors with their signs, and how far these can be off.
    """
    sizes = np.abs(errors)
    known = sizes > floors
    h, errors, floors, sizes = h[known], errors[known], floors[known], sizes[known]
    if len(h) < 2:
        return Fall()
    x, y = np.log(h), np.log(sizes)
    steps = np.subtract.outer(x, x)
    local = np.append(nan, np.diff(y) / np.diff(x))
    changes = np.append(0, np.cumsum(np.diff(np.sign(errors)) != 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.subtract.outer(np.log(sizes + floors), np.log(sizes - floors)) / steps
        rises = local > np.subtract.outer(y, y) / steps + RISING
    counted = (steps > 0.0) & ~rises & np.equal.outer(changes, changes)
    if not counted.any():
        return Fall()
    i, j = np.unravel_index(np.argmin(np.where(counted, most, inf)), most.shape)
    return Fall(float(most[i, j]), float(h[i]), float(h[j]))


def _is_far(exact: float, errors: Array, floors: Array, size: float) -> bool:
    """Tell whether a mean of the scheme is off by much, and comes nearer by much of itself at the last step size."""
    if len(errors) < NEEDED or not abs(errors[-1]) > NEAR * size:
        return False
    nearer = abs(errors[-2]) - abs(errors[-1]) + floors[-2:].sum()
    return bool(nearer > NEAR * abs(exact + errors[-1]))


def _order_of_errors(h: Array, errors: Array, floors: Array, size: float) -> FunctionalOrder:
    with np.errstate(invalid="ignore"):
        usable, well = (np.abs(errors) > times * floors for times in (ABOVE_FLOOR, FAR_ABOVE))
    if np.count_nonzero(well) >= NEEDED:
        return _with_lower_powers(_fit_order(h[well], errors[well], floors[well]), h, errors, floors)
    if np.count_nonzero(usable) >= NEEDED:
        return _fit_order(h[usable], errors[usable], floors[usable])._replace(high=inf)
    least = ABOVE_FLOOR * float(floors[-NEEDED:].max())
    if least <= EXACT * size and not usable[-NEEDED:].any():
        return FunctionalOrder(inf, inf, inf, note=f"no bias beyond {least:.1g} at any step size")
    note = f"errors above the noise ({least:.1g}) at fewer than {NEEDED} step sizes"
    return FunctionalOrder(nan, -inf, inf, informative=False, resolved=False, note=note)


def _with_lower_powers(found: FunctionalOrder, h: Array, errors: Array, floors: Array) -> FunctionalOrder:
    lowest = lowest_power(h, errors, floors, max(found.low - BETWEEN, BETWEEN))
    if lowest is None or not (lowest.clear or found.informative):
        return found
    order, c = lowest.power, f"{lowest.value:.2g}"
    if not lowest.clear:
        return found._replace(low=order, note=_join_notes(found.note, f"an error {c} h^{order:g} is not excluded"))
    what = f"{WRONG}: off by {c}" if order == 0.0 else f"error {c} h^{order:g}"
    note = f"{what} as h tends to 0, known to {lowest.known:.1g}"
    return FunctionalOrder(order, order, order, coefficient=lowest.value, h=found.h, note=note)


def _responsive(found: FunctionalOrder, responds: bool, why: str) -> FunctionalOrder:
    if np.isfinite(found.order) or not found.informative or responds:
        return found
    return FunctionalOrder(nan, -inf, inf, informative=False, fixed=True, note=why)


def _join_notes(*texts: str) -> str:
    return "; ".join(text for text in texts if text)


def _fit_order(h: Array, errors: Array, floors: Array) -> FunctionalOrder:
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
        note = f"the error changes sign {where}"
        return FunctionalOrder(nan, -inf, inf, informative=False, h=float(h[-1]), note=note)
    order = float(local[-1] if moving else limit)
    low = min(order, float(limit))
    # What falls after a change of sign rises again: no order that still moves is too low, nor are those before it.
    high = inf if moving or local[-1] > local[-2] + RISING else float(max(limit, *local[-2:]))
    spread = float(off[-1] + (off[-1] + off[-2]) / np.expm1(ratios[-1]))
    note = f"the order still changes, {local[-2]:.2f} to {local[-1]:.2f}" if moving else ""
    coefficient = float(errors[-1] / h[-1] ** order)
    return FunctionalOrder(order, low - spread, high + spread, coefficient=coefficient, h=float(h[-1]), note=note)
