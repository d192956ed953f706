"""Orders of the errors of means, for each observable, and selection of the observables that determine an order.

An error e(h) = c h^p + c' h^q, q > p, with an accidentally small leading coefficient changes sign between two step
sizes, or has local orders that have not settled: it gives no information on the scheme, and is excluded with a
message. Local orders that still increase give no upper bound: at steps too coarse for the problem they are too low.
The same holds if the mean of a scheme is far smaller or larger than the exact one. A residual error that does not
decrease is found by extrapolation. An error with too large an uncertainty is not excluded: it makes the least order
uncertain.

A mean without error gives no information if a symmetry of equation and scheme fixes it: it would also be right
for a scheme with too much noise or too long steps.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Problem
from ...numerics.statistics import RISING
from ..local.weak_order import SETTLED
from ..step.one_step import STILL, why_not_resolved
from .transition_errors import NEEDED, TransitionErrors

# Residual errors as h tends to 0: the coefficients of the lowest powers, by extrapolation.
#
# In e(h) = c_0 + c_1 h + c_2 h^2 + ..., a small c_0 hardly changes the local orders at the step sizes used, and
# neither does a c_1 small relative to c_2. Eliminating the next powers one after the other gives c_0 (Romberg), and
# applied to e(h)/h^q the coefficient of h^q if all lower ones vanish. The residual may instead belong to half powers:
# these are tried as well, and discard a coefficient that is unclear or that they contradict.


# A coefficient is clearly nonzero if it exceeds this multiple of its error bound.
# Rounding: a coefficient that is known to one digit.
CLEAR = 10.0
# Number of step sizes of an extrapolation.
# Theorem: elementary, without the two coarsest sizes, which bound its error, two are left.
FEWEST = 4


class Coefficient(NamedTuple):
    """Coefficient of the lowest power that does not, or may not, vanish.

    Attributes
    ----------
    power : float
        Exponent q of c h^q.
    value, known : float
        Coefficient c, and the bound of its error.
    """

    power: float
    value: float
    known: float

    @property
    def clear(self) -> bool:
        """Whether c differs clearly from 0."""
        return abs(self.value) > CLEAR * self.known

    @property
    def details(self) -> dict[str, object]:
        """The leading term C h^p of an error as details of a finding; see `leading_columns`."""
        return dict(zip(leading_columns(""), self, strict=True))


def leading_columns(error: str) -> dict[str, str]:
    """Return the names and meanings of the columns for the leading term C h^p of an error, given in words."""
    return {
        "error_power": f"p of the leading term C h^p of the {error}",
        "error_constant": "C, without sampling; empty if it is not known",
        "error_constant_known": "bound of the error of C",
    }


def lowest_power(h: Array, errors: Array, floors: Array, below: float) -> Coefficient | None:
    """Return the lowest power below a bound with a coefficient larger than its uncertainty, or None.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, each half of the previous one.
    errors, floors : ndarray, shape (H,)
        Signed errors, and bounds of their uncertainty.
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
    """Return the values extrapolated to h = 0, and a bound of the error of the extrapolation.

    The bound is the largest change if the finest step size, the coarsest or the two coarsest are left out: the first
    estimates the effect of a further, finer one.
    """
    # With about a dozen numbers, lists take a third of the time of arrays.
    tables, blur = [values.tolist()], floors.tolist()
    for column in range(1, len(values)):
        ratio = 2.0 ** (step * column)
        tables.append([(ratio * fine - coarse) / (ratio - 1.0) for coarse, fine in pairwise(tables[-1])])
        blur = [(ratio * fine + coarse) / (ratio - 1.0) for coarse, fine in pairwise(blur)]
    (limit,), before = tables[-1], [*tables[-2], tables[-3][-1]]
    return limit, max(abs(each - limit) for each in before) + blur[0]


# An error is used if it is known to one digit, and can refute a scheme if it is known to two: a local order then has
# an error below 0.03.
# Rounding: log2 of 101/99 is 0.029, where errors halve.
ABOVE_FLOOR, FAR_ABOVE = 10.0, 100.0
# Rounding hides the last digits of e(h)/h^p on fine steps, a remainder those on coarse ones: the steps count on which
# errors are larger than what is known of them by one of these factors.
# Words: of the columns of an error's constant.
LEAST_SIGNALS = (10.0, 1e3, 1e5)


def leading_error(h: Array, errors: Array, floors: Array, order: float) -> Coefficient | None:
    """Return the leading term C h^p of an error, or None where C is not known to a tenth.

    With p the multiple of 1/2 next to the order, e(h)/h^p is extrapolated to h = 0, in powers of h and in powers of
    sqrt(h), which the errors of some schemes have. The better known limit counts, as well as both agree.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, each half of the one before.
    errors, floors : ndarray, shape (H,)
        Errors with their signs, and how far they can be off.
    order : float
        Of the error as h tends to 0; not finite where there is none.

    Returns
    -------
    Coefficient or None
    """
    power = 0.5 * round(2.0 * order) if np.isfinite(order) else 0.0
    if not power > 0.0:
        return None
    scaled, blur = errors / h**power, floors / h**power
    rows = (_last_row(np.abs(errors) > least * floors) for least in LEAST_SIGNALS)
    found = [_agreed(*(_limit(scaled[row], blur[row], step) for step in (1.0, 0.5))) for row in rows if row]
    best = Coefficient(power, *min(found, key=lambda each: each[1], default=(0.0, 0.0)))
    return best if best.clear else None


def _agreed(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    """Return the better known of two limits, known no better than the other one agrees."""
    (value, known), (again, _) = sorted((one, other), key=lambda each: each[1])
    return value, max(known, abs(again - value))


def _last_row(known: Array) -> slice | None:
    """Return the finest step sizes in a row of which something is known, or None where they are too few."""
    ends = np.concatenate([[-1], np.flatnonzero(~known), [len(known)]])
    rows = [slice(first + 1, last) for first, last in pairwise(ends.tolist()) if last - first > FEWEST]
    return rows[-1] if rows else None


# Errors count as zero if this part of the observable's size would have been detected at the finest step sizes.
# Size: of what is looked for; the reason gives the smallest size that would have been found.
EXACT = 1e-6
# If a scheme gives the mean times exp(-K h^p), its local orders are p (1 - K h^p/2 + ...), which is right to a tenth
# if its error is below a tenth of the mean. Longer steps, for which the scheme's mean is nearly 0, show the order 0.
# Theorem: elementary, the expansion above.
NEAR = 0.1
# Lower powers are tested if they are below the order by more than this.
# Theorem: orders are multiples of 1/2, and this is half of that.
BETWEEN = 0.25
WRONG = "wrong limit"


class Fall(NamedTuple):
    """Mean order of an error between two step sizes.

    Attributes
    ----------
    most : float
        Upper bound of the order, given the uncertainty of the errors; infinite if there is none.
    coarse, fine : float
        The two step sizes.
    """

    most: float = inf
    coarse: float = nan
    fine: float = nan


class FunctionalOrder(NamedTuple):
    """Order of the error of an observable's mean.

    Attributes
    ----------
    order : float
        Local order at the finest usable step sizes, extrapolated to h = 0 if it has settled. Infinite if no error
        is detected, NaN if no order can be estimated.
    low, high : float
        Interval of the order, given the uncertainty `TransitionErrors.floors`; infinite ends if errors are unknown.
    informative : bool
        Whether a verdict may be based on it.
    resolved : bool
        False if it is not informative because of insufficient accuracy, so that this observable may have a lower
        order.
    fixed : bool
        True if it is not informative because a symmetry fixes the mean, or because a step does not change the state.
    coefficient : float
        c of e(h) = c h^order at the finest usable step size.
    h : float
        Finest usable step size.
    note : str
    fall : Fall
        Slowest decrease between two step sizes, also if too few errors are known for an order.
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


def functional_orders(record: TransitionErrors) -> tuple[FunctionalOrder, ...]:
    """Return the order of each observable.

    Parameters
    ----------
    record : TransitionErrors
        Step sizes are ordered from coarse to fine.

    Returns
    -------
    tuple of FunctionalOrder
    """
    columns = zip(record.errors.T, record.floors.T, record.sizes, record.response, strict=True)
    why = STILL if record.still else "by symmetry its mean is correct even if the noise is too strong"
    return tuple(
        _responsive(
            order_of(record.h, errors, floors, size), response > max(EXACT * size, ABOVE_FLOOR * floors[-1]), why
        )
        for errors, floors, size, response in columns
    )


def least_order(orders: Sequence[FunctionalOrder]) -> tuple[float, float]:
    """Return the interval of the least order of all observables whose leading coefficient does not vanish.

    An unresolved observable removes the lower bound; without any observables the interval is unbounded.
    """
    counted = [found for found in orders if found.informative or not found.resolved]
    return min((found.low for found in counted), default=-inf), min((found.high for found in counted), default=inf)


def widen(orders: Sequence[FunctionalOrder], view: Problem) -> tuple[FunctionalOrder, ...]:
    """Return the orders, without upper bound if no step size with a detected error resolves the problem."""
    coarse = [why_not_resolved(view, found.h) if np.isfinite(found.h) else "" for found in orders]
    return tuple(
        found._replace(high=inf, note=_join_notes(found.note, why)) if why else found
        for found, why in zip(orders, coarse, strict=True)
    )


def order_of(h: Array, errors: Array, floors: Array, size: float, exact: float = nan) -> FunctionalOrder:
    """Return the order of the errors of one mean.

    It has no upper bound if the mean of the scheme is still far from its limit.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes from coarse to fine.
    errors, floors : ndarray, shape (H,)
        Signed errors, and bounds of their uncertainty.
    size : float
        Size of the observable.
    exact : float
        Mean of the solution; NaN to skip the check that the scheme's mean is near its limit.

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
    """Return the decrease between two step sizes whose order has the smallest upper bound.

    Between h_i > h_j an error has at most the order log((|e_i| + f_i)/(|e_j| - f_j)) / log(h_i/h_j). Pairs with a
    change of sign between them are excluded, and pairs between which the local order increases: it is too low for
    steps as coarse as h_i then.

    Parameters
    ----------
    h, errors, floors : ndarray, shape (H,)
        Step sizes from coarse to fine, signed errors, and bounds of their uncertainty.
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
    """Return whether a scheme's mean has a large error that still decreases much at the last step size."""
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
    # Local orders that decrease after a change of sign increase again: an order that has not settled is no upper
    # bound, and neither are the previous ones.
    high = inf if moving or local[-1] > local[-2] + RISING else float(max(limit, *local[-2:]))
    spread = float(off[-1] + (off[-1] + off[-2]) / np.expm1(ratios[-1]))
    note = f"the order still changes, {local[-2]:.2f} to {local[-1]:.2f}" if moving else ""
    coefficient = float(errors[-1] / h[-1] ** order)
    return FunctionalOrder(order, low - spread, high + spread, coefficient=coefficient, h=float(h[-1]), note=note)
