"""Local weak orders from the defects of one step.

Orders are computed for every test function and state separately, from the finest levels, and the lowest one is used:
in a maximum over the defects a larger defect of high order could hide one of low order.

Defects are relative to |phi| + |D phi|_1 + |dx|^2, where |dx| is the length of a step. The floor is rounding of this
scale: a defect below the floor at all but the coarsest step sizes is called exact, regardless of its order.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...numerics.statistics import EPS
from ..step import test_functions
from ..step.romberg import weights
from ..step.two_rules import AGREEMENT
from .orders import CLEAR, TOLERANCE, finest_usable, pick

# At this multiple of the rounding error, rounding changes a local order by less than 0.01.
# Rounding: log2 of 301/299 is 0.0096.
FLOORS = 300.0
# Defects with fewer levels above rounding are exact to round-off.
# Theorem: elementary, a local order needs two step sizes, and its change a third.
FEWEST_LEVELS = 3
# Above a plateau an order needs more levels.
# Theorem: elementary, the five sizes of one window of `SMOOTH`: at the first four, errors of a solver are not seen.
ABOVE_PLATEAU = 5
# Largest difference of the last two local orders for which their limit is extrapolated.
SETTLED = 0.3
# Coefficients, coarsest step size first, that annihilate h, h^(3/2), h^2 and h^3 at five step sizes of ratio 1/2.
# They leave 1/200 of h^(5/2), and 1/13 of a constant.
SMOOTH = np.poly([0.5, 0.5**1.5, 0.25, 0.125])[::-1]
# Theorem: elementary, between the two parts above, twice the first.
ROUGH = 0.01
# From one step size to the next, the roughness of powers from h^(5/2) on decreases below this part; errors of a
# solver do not.
# Theorem: elementary, 2^(-5/2) = 0.18.
STALL = 0.2
# A plateau consists of levels at which this share of the defects is rough.
CROWD = 0.25
# Shortest of the step sizes, in units of time.
# Size: of the shortest step.
FINEST = 2.0**-18
# Low orders are attributed to coarse steps if this share of them is higher at much shorter step sizes.
MOST = 0.5


class LocalWeak(NamedTuple):
    """Weak defects of one step for F test functions, S states and H step sizes; times count as separate states.

    Attributes
    ----------
    h : ndarray, shape (H,)
    defect : ndarray, shape (F, S, H)
        Signed defects D.
    scale : ndarray, shape (F, S, H)
        Largest |phi| at the nodes plus |D phi|_1 + |dx|^2, where |dx| is the length of a step; one rounding error is
        eps times this. `defect` and `scale` are NaN where a step or an expectation is not finite.
    trees : ndarray, shape (S,)
        Number K of extrapolated trees of the reference.
    dimension : ndarray, shape ()
        Number d of components.
    time : ndarray, shape (S,)
        Index of each state's time among the probed ones; states of `cloud` and further ones have different indices,
        as if their times were different.
    further : ndarray, shape (S,)
        1 for states that are not of `cloud`, else 0.
    apart : ndarray, shape (F, R, H)
        Change of the defects at the first R states if another rule for the noise is used. R is 0
        for a discrete law, for which means are exact.
    own_rounding : ndarray, shape (H,)
        Largest change of a step, in units of the arguments of test functions, by one rounding error of its state,
        beyond the perturbation: rounding within the step, and errors of a solver that stops at a tolerance.
    """

    h: Array
    defect: Array
    scale: Array
    trees: Array
    dimension: Array
    time: Array
    further: Array
    apart: Array
    own_rounding: Array

    @property
    def rules(self) -> "LocalWeak":
        """The record with the differences between two rules as defects, at the states where both were used."""
        count = self.apart.shape[1]
        trees, time, further = (part[:count] for part in (self.trees, self.time, self.further))
        parts = {"scale": self.scale[:, :count], "trees": trees, "time": time, "further": further}
        return self._replace(defect=self.apart, **parts)

    def combine(self, coefficients: Array) -> "LocalWeak":
        """Return the defects of the linear combination of test functions with these coefficients."""
        # Functions with coefficient 0 are left out, because their defects may be NaN.
        used = coefficients != 0.0
        c = coefficients[used]
        defect, apart = (np.tensordot(c, part[used], 1)[None] for part in (self.defect, self.apart))
        return self._replace(defect=defect, scale=np.tensordot(np.abs(c), self.scale[used], 1)[None], apart=apart)


class WeakOrder(NamedTuple):
    """Local weak orders: orders of the defects minus 1.

    Attributes
    ----------
    orders : ndarray, shape (F, S)
        Limit as h tends to 0 if the order has settled, else the last order. Infinite if the
        defect is exact up to rounding or up to the reference; NaN if it is not finite or hidden by a tolerance.
    last : ndarray, shape (F, S)
        Order between the two finest usable step sizes; minus infinity if the defect changes sign there.
    settled : ndarray of bool, shape (F, S)
    plateau_h : float
        Largest step size at which a solver's tolerance hides defects and makes claims void; 0 if none does.
    dimension : int
    time : ndarray, shape (S,)
        Index of each state's time among the probed ones.
    function : str
        Name of the function if it is not one of the test functions.
    h : float
        Shortest step size.
    later : ndarray, shape (F, S), or None
        Orders at much shorter step sizes, if computed.
    rules : ndarray, shape (F, R)
        Order below which two rules for the noise agree, at the first R states: the order of the means of one step
        minus 1. Infinite if their difference is rounding, has no settled order, or is a small part of the defect.
    """

    orders: Array
    last: Array
    settled: Mask
    plateau_h: float
    dimension: int
    time: Array
    function: str = ""
    h: float = 0.0
    later: Array | None = None
    rules: Array = np.zeros((0, 0))

    @property
    def order(self) -> float:
        """Lowest settled order; infinite if there is none."""
        return float(np.min(self.orders, where=self.settled, initial=np.inf))

    def count_states(self, found: Mask) -> tuple[int, int]:
        """Return the number of states in a mask (S,), and of all states, at the time with the largest share."""
        counts = ((int(found[self.time == time].sum()), int((self.time == time).sum())) for time in set(self.time))
        return max(counts, key=lambda count: count[0] / count[1])

    def share(self, found: Mask) -> Array:
        """Return the share of states in a mask, at the time with the largest share; shape (...) for (..., S)."""
        if not found.any():
            return np.zeros(found.shape[:-1])
        shares = [found[..., self.time == time].mean(axis=-1) for time in set(self.time.tolist())]
        return np.asarray(np.max(shares, axis=0))

    def at_many(self, found: Mask, part: float) -> bool:
        """Return whether for some function a mask holds at a share of a time's states, and at two unless it has one.

        A zero of a defect at some h is a coincidence of a single state.

        Parameters
        ----------
        found : ndarray of bool, shape (F, S)
        part : float
            Share of the states.
        """
        here = [found[:, self.time == time] for time in set(self.time.tolist())]
        return any(bool((at.sum(axis=1) >= max(part * at.shape[1], min(2, at.shape[1]))).any()) for at in here)

    def differing_share(self, bound: float) -> float:
        """Return the share of states at which two rules differ on half of the defects with an order below `bound`.

        A defect that happens to be small at a state is no larger than the difference of the rules there.
        """
        if not self.rules.size:
            return 0.0
        differ = self.rules < bound
        low = differ | (self.orders[:, : differ.shape[1]] < bound)
        return float(np.mean(low.any(axis=0) & (2 * differ.sum(axis=0) >= low.sum(axis=0))))

    def rises(self, low: Mask, bound: float) -> bool:
        """Return whether most orders in a mask, which are below `bound`, are above it at much shorter step sizes.

        Defects hidden by rounding there do not count as higher.
        """
        if self.later is None or not low.any():
            return False
        return float((np.isfinite(self.later) & (self.later >= bound))[low].mean()) > MOST

    def least(self, among: Mask) -> str:
        """Describe the lowest order of the defects in a mask, with its test function."""
        function, state = np.unravel_index(np.argmin(np.where(among, self.orders, np.inf)), among.shape)
        name = self.function or test_functions.names(self.dimension)[function]
        if np.isneginf(self.orders[function, state]):
            return f"no weak order from one step, whose error changes sign with h, of E[{name}]"
        return f"weak order {self.orders[function, state]:.2f} from one step, of E[{name}]"


def weak_order(record: LocalWeak, shortest: LocalWeak | None = None) -> WeakOrder:
    """Return the local weak orders.

    An order is the last one above the floors, extrapolated if it has settled. By Richardson: for errors
    c h^p (1 + a h) local orders differ from p by a multiple of h, so that the limit differs from the last one by its
    last change.

    Parameters
    ----------
    record : LocalWeak
    shortest : LocalWeak, optional
        Defects at step sizes far below those of the record, for orders that are low there.

    Returns
    -------
    WeakOrder
    """
    found, fine = (
        _orders(record)._replace(rules=_rules_order(record)),
        None if shortest is None else _orders(shortest),
    )
    if fine is None or fine.orders.shape != found.orders.shape:
        return found
    return found._replace(later=fine.orders)


def _rules_order(record: LocalWeak) -> Array:
    """Return the order of the difference between two rules; see `WeakOrder`."""
    if not record.apart.size:
        return np.full(record.apart.shape[:2], np.inf)
    rules, defect = record.rules, record.defect[:, : record.apart.shape[1]]
    rounding = _rounding(rules)
    with np.errstate(invalid="ignore"):
        agree = np.abs(record.apart) <= np.maximum(AGREEMENT * np.abs(defect), rounding)
        finest, *_ = finest_usable(np.abs(record.apart) > rounding)
    found = _orders(rules)
    # At long steps the rules also differ by terms of other orders.
    return np.where(found.settled & ~pick(agree, finest), found.orders, np.inf)


def _orders(record: LocalWeak) -> WeakOrder:
    size, rounding = np.abs(record.defect), _rounding(record)
    noise, rough = _roughness(record, rounding)
    tolerance, plateau_h = _plateau(record, noise, rough)
    # Errors of a solver hide an order; a defect below them is not exact.
    usable = size > np.maximum(rounding, np.maximum(CLEAR * tolerance, FLOORS * record.own_rounding) * record.scale)
    fewest = ABOVE_PLATEAU if plateau_h else FEWEST_LEVELS
    usable &= usable.sum(axis=-1, keepdims=True) >= fewest
    finest, (last, before) = _last_orders(record.h, record.defect, usable)
    with np.errstate(invalid="ignore"):
        change = last - before
    settled = (np.abs(change) < SETTLED) & ~pick(rough, finest)
    orders = np.where(settled, last + change, last) - 1.0
    # The reference has an error of order K: a defect of that order is attributed to it.
    exact = ((size > rounding).sum(axis=-1) < FEWEST_LEVELS) | (orders > record.trees - 0.5)
    orders = np.where(exact, np.inf, orders)
    orders = np.where(np.isfinite(size[..., -1]), orders, np.nan)
    settled &= np.isfinite(orders)
    # A zero of a defect affects many further states, which are close to each other: only their settled orders are
    # used.
    orders = np.where((record.further > 0.0) & ~settled & ~np.isnan(orders), np.inf, orders)
    counts = int(record.dimension), record.time
    return WeakOrder(orders, last - 1.0, settled, plateau_h, *counts, h=float(record.h[-1]))


def _rounding(record: LocalWeak) -> Array:
    """Return the size below which a defect has no order, shape (F, S, H)."""
    amplified = [np.abs(weights(int(K))).sum() for K in record.trees]
    return np.asarray(FLOORS * EPS * np.reshape(amplified, (-1, 1)) * record.scale)


def _roughness(record: LocalWeak, rounding: Array) -> tuple[Array, Mask]:
    """Return the deviation of defects from sums of powers of h over five sizes, and where solver errors show.

    These are small, irregular or constant in h, and do not decrease. At the four coarsest sizes they cannot be
    detected.
    """
    noise, sizes = np.abs(_sum_windows(record.defect, SMOOTH)), np.abs(record.defect)
    grain = _sum_windows(rounding, np.abs(SMOOTH)) / CLEAR
    rough = noise > ROUGH * _sum_windows(sizes, np.abs(SMOOTH)) + grain
    rough[..., 1:] &= noise[..., 1:] > STALL * noise[..., :-1]
    return _with_coarsest(noise / SMOOTH.sum()), _with_coarsest(rough) & (sizes < TOLERANCE * record.scale)


def _sum_windows(values: Array, weights: Array) -> Array:
    """Return the weighted sums of successive values along the last axis."""
    count = values.shape[-1] - len(weights) + 1
    return np.asarray(sum(weight * values[..., k : k + count] for k, weight in enumerate(weights)))


def _with_coarsest(values: Array) -> Array:
    """Return values of windows assigned to the last step size of each, and zeros for the first step sizes."""
    nothing = np.zeros((*values.shape[:-1], len(SMOOTH) - 1), dtype=values.dtype)
    return np.concatenate([nothing, values], axis=-1)


def _plateau(record: LocalWeak, noise: Array, rough: Mask) -> tuple[Array, float]:
    """Return the relative size of a solver's errors at each step size, and the largest step size of their plateau.

    The plateau extends to the finest step size, with enough of the defects rough at each size, except for gaps of
    one. Above it, the errors are those of the defects that they reach first; without a plateau they are 0.
    """
    crowded = rough.mean(axis=(0, 1)) > CROWD
    crowded[1:-1] |= crowded[:-2] & crowded[2:]
    first = int(np.flatnonzero(~crowded)[-1]) + 1
    if first == len(crowded):
        return np.zeros_like(record.h), 0.0
    sizes = (noise / record.scale).max(axis=(0, 1), where=rough, initial=0.0)
    largest = sizes[first:].max()
    return np.append(np.minimum(sizes[:first], largest), np.full(len(sizes) - first, largest)), float(record.h[first])


def _last_orders(h: Array, defect: Array, usable: Mask) -> tuple[Array, Array]:
    """Return the finest usable level and the last two local orders, finest first.

    They are NaN if no level is usable, and minus infinity across a change of sign.
    """
    index = np.stack(finest_usable(usable))
    values, steps = np.stack([pick(defect, level) for level in index]), h[index]
    with np.errstate(all="ignore"):
        ratios = np.maximum(values[1:] / values[:-1], 0.0)
        orders = np.log(ratios) / np.log(steps[1:] / steps[:-1])
    return index[0], np.where(usable.any(axis=-1), orders, np.nan)
