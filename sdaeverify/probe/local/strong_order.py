"""Local strong order: orders of the defects of one step, from which the strong order follows.

With p2, p1 the orders in h of max_x ||d_self||_{L2} and max_x |E d_self|, a scheme whose steps follow the equation
(see `consistency`) converges strongly to the Ito solution (Milstein 1988, Theorem 1). By the telescoping sum of
X^h - X^{h/2} its order is

    p = min(p2 - 1/2, p1 - 1).
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from .consistency import Consistency
from .orders import ROUNDING, LocalOrders, finest_usable, last_orders, pick
from .reach import mark_rows
from .strong_defects import LEVELS, LocalStrong

# From this order of the root mean square on, errors of a rule of degree 3 are of the size of those of the mean.
# Theorem: these errors have order 2, and root mean squares orders that are multiples of 1/2: the midpoint.
FOURTH = 1.75
# Accuracy of local orders, from schemes of known order; two orders may differ by twice as much.
# Measured by tests/probe/test_local_strong.py: orders of right schemes.
ACCURACY = 0.02
# Largest order that is none: 0 up to the tolerance of strong orders.
# Theorem: the least order is 1/2.
NO_ORDER = 0.1


class StrongOrder(NamedTuple):
    """Local strong order of one or more components.

    Attributes
    ----------
    order : float
        p = min(p2 - 1/2, p1 - 1); infinite if the defects are rounding. Without resolved means it is p2 - 1/2.
    p2, p1 : float
        Lowest orders over the components; p1 is NaN if means are not resolved.
    typical : float
        Median over the states of the order at each of them, or of its extrapolation to the next step size if higher.
    plateau_h : float
        Largest step size at which a solver's tolerance hides the defects; 0 if none does.
    means : bool
        Whether means are resolved.
    ahead : float
        Extrapolated order at the next smaller step size.
    turns : bool
        Whether the mean error is near 0 between the finest step sizes, so that its order is unreliable.
    too_coarse : float
        Shortest of the step sizes at which one step has no order, if it has one at much shorter ones; else 0.
    each : tuple of (float, float)
        `order` and `ahead` for each kind of defect and group of states.
    before : float
        Highest order, of root mean squares, between two earlier step sizes of a group of states; minus infinity if it
        is not known.
    memory : float
        Order of the effect of a run's memory; infinite without memory.
    departure : str
        How short steps deviate from the equation; empty if they do not.
    compared : bool
        Whether short steps were compared with the equation.
    """

    order: float
    p2: float
    p1: float
    typical: float
    plateau_h: float
    means: bool
    ahead: float
    turns: bool = False
    too_coarse: float = 0.0
    each: tuple[tuple[float, float], ...] = ()
    before: float = -inf
    memory: float = inf
    departure: str = ""
    compared: bool = True

    @property
    def converges(self) -> bool:
        """Whether the step has an order; False if it is NaN."""
        return self.order > NO_ORDER


def strong_orders(record: LocalStrong, shortest: LocalStrong | None = None) -> tuple[StrongOrder, ...]:
    """Return the order of each component and, last, of the full state.

    Parameters
    ----------
    record : LocalStrong
    shortest : LocalStrong, optional
        Defects at step sizes far below those of the record, for steps that have no order there.
    """
    found = _orders(record)
    if shortest is None:
        return found
    pairs, h = zip(found, _orders(shortest), strict=True), float(record.h[-1])
    return tuple(order._replace(too_coarse=h) if converges_later(order, fine) else order for order, fine in pairs)


def with_consistency(
    orders: Sequence[StrongOrder], compared: Consistency | None, names: Sequence[str]
) -> tuple[StrongOrder, ...]:
    """Return the orders of the components and of the full state with their deviations from the equation.

    Parameters
    ----------
    orders : sequence of StrongOrder
        Of each component and, last, of the full state.
    compared : Consistency or None
        None if short steps cannot be compared with the equation.
    names : sequence of str
        Names of the components.
    """
    if compared is None:
        return tuple(order._replace(compared=False) for order in orders)
    pairs = zip(orders, (*range(len(names)), None), strict=True)
    return tuple(order._replace(departure=compared.departure(names, index)) for order, index in pairs)


def converges_later(order: StrongOrder, fine: StrongOrder) -> bool:
    """Return whether a step has an order at much shorter step sizes only.

    A scheme that bounds its drift or its noise does so in the unit of time. Defects of a step without an order are no
    smaller than h, and rounding does not hide them; those that it hides have an order.

    Parameters
    ----------
    order, fine : StrongOrder
        At the step sizes that are probed first, and at much shorter ones.
    """
    return not order.converges and fine.converges


def _orders(record: LocalStrong) -> tuple[StrongOrder, ...]:
    defects, components = _find_orders(record), (*range(len(record.reached)), None)
    return tuple(_take_order(record, defects, mark_rows(record.reached, component)) for component in components)


def _find_orders(record: LocalStrong) -> tuple[LocalOrders, LocalOrders]:
    """Return local orders of root mean squares and of means, by component.

    Returns
    -------
    LocalOrders, shape (2, n, G)
        For the largest defects of all states of `cloud`, and of all further states, if there are any: large errors
        far out thus do not hide errors near the start.
    LocalOrders, shape (2, n, S)
        For each state.
    """
    both, scale = np.stack([record.rms, record.mean]), record.scale
    groups = record.groups
    # The maximum of each group is appended like an additional state.
    both = np.concatenate([both, *(both[:, :, group].max(axis=2, keepdims=True) for group in groups)], axis=2)
    scale = np.concatenate([scale, *(scale[group].max(axis=0, keepdims=True) for group in groups)])
    found = last_orders(record.h, both, ROUNDING * scale, scale, len(LEVELS))
    count = len(record.scale)
    worst, states = (LocalOrders(*(e[..., part] for e in found)) for part in (slice(count, None), slice(count)))
    return worst, states


def _take_order(record: LocalStrong, defects: tuple[LocalOrders, LocalOrders], rows: Array) -> StrongOrder:
    found, states = (LocalOrders(*(each[:, rows] for each in orders)) for orders in defects)
    order = found.order.copy()
    # At large coefficients, steps of the same size are coarser: an order that still increases there is extrapolated.
    order[..., 1:] = np.fmax(order, found.ahead)[..., 1:]
    p2, p1 = order.min(axis=(1, 2))
    means = _resolves_means(record, float(p2))
    now, ahead = (_strong(each, means=means) for each in (found.order, found.ahead))
    plateaus = found.plateau_h.max(axis=(1, 2))
    return StrongOrder(
        order=float(_strong(order, means=means).min()),
        p2=float(p2),
        p1=float(p1) if means else np.nan,
        typical=_typical(record, states, means=means),
        plateau_h=float(plateaus.max() if means else plateaus[0]),
        means=means,
        ahead=float(ahead.min()),
        turns=_turns(record, rows),
        each=tuple(zip(now.tolist(), ahead.tolist(), strict=True)),
        before=max(_earlier(record, rows, group) for group in record.groups),
    )


def _earlier(record: LocalStrong, rows: Array, group: Mask) -> float:
    """Return the highest strong order between two step sizes before the finest usable pair, from one step."""
    size, floor = record.rms[rows][:, group].max(axis=1), ROUNDING * record.scale[group].max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.diff(np.log(size), axis=1) / np.diff(np.log(record.h))
    usable = np.isfinite(found) & (size[:, 1:] > floor[1:])
    last = usable.shape[1] - 1 - usable[:, ::-1].argmax(axis=1)
    earlier = usable & (np.arange(usable.shape[1]) < last[:, None])
    # Of each component the highest, and of these the lowest, which is that of the state.
    return float(np.where(earlier, found, -np.inf).max(axis=1).min(initial=np.inf)) - 0.5


def _strong(powers: Array, *, means: bool) -> Array:
    """Return the strong orders by group of states, from root mean squares and, if resolved, from means.

    Parameters
    ----------
    powers : ndarray, shape (2, n, G)
    means : bool
    """
    rms, mean = powers[0].min(axis=0) - 0.5, powers[1].min(axis=0) - 1.0
    return np.concatenate([rms, mean]) if means else rms


def _turns(record: LocalStrong, rows: Array) -> bool:
    """Return whether the largest mean of a group of states turns between two of the finest usable step sizes."""
    return any(_group_turns(record, rows, group) for group in record.groups)


def _group_turns(record: LocalStrong, rows: Array, group: Mask) -> bool:
    size = record.mean[rows][:, group]
    worst = np.nan_to_num(size, nan=-1.0).argmax(axis=1)[:, None]
    turned = np.take_along_axis(record.turned[rows][:, group], worst, axis=1)[:, 0] > 0.0
    usable = np.take_along_axis(size, worst, axis=1)[:, 0] > ROUNDING * record.scale[group].max(axis=0)
    finest = (finest_usable(usable[:, :count]) for count in (len(LEVELS), len(record.h)))
    return any(bool((pick(turned, last) | pick(turned, before)).any()) for last, before, _ in finest)


def _resolves_means(record: LocalStrong, p2: float) -> bool:
    """Return whether means are resolved up to the order of the root mean squares.

    A rule of degree 3 has errors of order h^2 in products of four variables, which is the order of means at order 1.
    """
    return float(record.means) == 1.0 or p2 < FOURTH


def at_most(order: StrongOrder, bound: float) -> StrongOrder:
    """Return the order of a component with the error of another one, and an additional error of order `bound`."""
    least = [float(np.minimum(value, bound)) for value in (order.order, order.typical, order.ahead)]
    each = tuple((min(now, bound), min(ahead, bound)) for now, ahead in order.each)
    return order._replace(order=least[0], typical=least[1], ahead=least[2], each=each)


def _typical(record: LocalStrong, found: LocalOrders, *, means: bool) -> float:
    """Return the median of the orders of states, at the worst time."""
    p2, p1 = np.fmax(found.order, found.ahead).min(axis=1)
    typical = np.fmin(p2 - 0.5, p1 - 1.0) if means else p2 - 0.5
    return float(np.median(typical.reshape(int(record.times), -1), axis=1).min())
