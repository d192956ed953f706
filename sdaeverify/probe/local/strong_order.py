"""Local strong order: orders of the defects of one step, from which consistency and the strong order follow.

With p2, p1 the orders in h of max_x ||d_self||_{L2} and max_x |E d_self|, and q2, q1 those of d_em, the scheme is
consistent if and only if q2 > 0.9 and q1 > 1.4. It then converges strongly to the Ito solution (Milstein 1988,
Theorem 1) and, by the telescoping sum of X^h - X^{h/2}, with the order

    p = min(p2 - 1/2, p1 - 1).
"""

from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from .orders import ROUNDING, LocalOrders, finest_usable, last_orders, pick
from .reach import mark_rows
from .strong_defects import EM, LEVELS, SELF, LocalStrong

# A consistent step has q2 >= 1 and q1 >= 3/2.
LEAST_Q2, LEAST_Q1 = 0.9, 1.4
# From this order of the root mean square on, errors of a rule of degree 3 are of the size of those of the mean.
FOURTH = 1.75
# Accuracy of local orders, from schemes of known order; two orders may differ by twice as much.
ACCURACY = 0.02


class StrongOrder(NamedTuple):
    """Local strong order of one or more components.

    Attributes
    ----------
    order : float
        p = min(p2 - 1/2, p1 - 1); infinite if the defects are rounding. Without resolved means it is p2 - 1/2.
    p2, p1, q2, q1 : float
        Lowest orders over the components; p1 and q1 are NaN if means are not resolved.
    consistent : bool
        q2 > 0.9 and, if known, q1 > 1.4.
    inconsistent_share : float
        Share of the states at which this fails.
    typical : float
        Median over the states of the order at each of them, or of its extrapolation to the next step size if higher.
    plateau_h : float
        Largest step size at which a solver's tolerance hides the defects; 0 if none does.
    means : bool
        Whether means are resolved.
    ahead : float
        Extrapolated order at the next smaller step size.
    consistent_later : bool
        Whether a step from a state that the scheme has reached is consistent.
    turns : bool
        Whether the mean error is near 0 between the finest step sizes, so that its order is unreliable.
    too_coarse : float
        Shortest of the step sizes at which one step does not follow the equation, if it does at much shorter
        ones; else 0.
    each : tuple of (float, float)
        `order` and `ahead` for each kind of defect and group of states.
    memory : float
        Order of the effect of a run's memory; infinite without memory.
    """

    order: float
    p2: float
    p1: float
    q2: float
    q1: float
    consistent: bool
    inconsistent_share: float
    typical: float
    plateau_h: float
    means: bool
    ahead: float
    consistent_later: bool
    turns: bool = False
    too_coarse: float = 0.0
    each: tuple[tuple[float, float], ...] = ()
    memory: float = inf


def strong_orders(record: LocalStrong, shortest: LocalStrong | None = None) -> tuple[StrongOrder, ...]:
    """Return the order of each component and, last, of the full state.

    Parameters
    ----------
    record : LocalStrong
    shortest : LocalStrong, optional
        Defects at step sizes far below those of the record, for steps that do not follow the equation there.
    """
    found = _orders(record)
    if shortest is None:
        return found
    pairs, h = zip(found, _orders(shortest), strict=True), float(record.h[-1])
    slow = bool(record.h[0] > LEVELS[0])
    return tuple(
        order._replace(too_coarse=h) if follows_later(order, fine, slow=slow) else order for order, fine in pairs
    )


def follows_later(order: StrongOrder, fine: StrongOrder, *, slow: bool) -> bool:
    """Return whether a step follows the equation at much shorter steps only; defects hidden by rounding do not count.

    A scheme that bounds its drift or its noise does so in the unit of time. For a slow equation, which is probed with
    longer steps, rounding may hide all mean errors of steps that are short for such a scheme.

    Parameters
    ----------
    order, fine : StrongOrder
        At the step sizes that are probed first, and at much shorter ones.
    slow : bool
        Whether the equation is slow.
    """
    seen2, seen1 = order.q2 > LEAST_Q2 or isfinite(fine.q2), order.q1 > LEAST_Q1 or isfinite(fine.q1)
    return seen2 and (seen1 or not fine.means or slow) and fine.consistent and not order.consistent


def _orders(record: LocalStrong) -> tuple[StrongOrder, ...]:
    defects, components = _find_orders(record), (*range(len(record.reached)), None)
    return tuple(_take_order(record, defects, mark_rows(record.reached, component)) for component in components)


def _find_orders(record: LocalStrong) -> tuple[LocalOrders, LocalOrders]:
    """Return local orders of root mean squares and of means, by kind of defect and component.

    Returns
    -------
    LocalOrders, shape (2, 3, n, G)
        For the largest defects of all states of `cloud`, and of all further states, if there are any: large errors
        far out thus do not hide errors near the start.
    LocalOrders, shape (2, 3, n, S)
        For each state.
    """
    both, scale = np.stack([record.rms, record.mean]), record.scale
    groups = record.groups
    # The maximum of each group is appended like an additional state.
    both = np.concatenate([both, *(both[:, :, :, group].max(axis=3, keepdims=True) for group in groups)], axis=3)
    scale = np.concatenate([scale, *(scale[group].max(axis=0, keepdims=True) for group in groups)])
    found = last_orders(record.h, both, ROUNDING * scale, scale, len(LEVELS))
    count = len(record.scale)
    worst, states = (LocalOrders(*(e[..., part] for e in found)) for part in (slice(count, None), slice(count)))
    return worst, states


def _take_order(record: LocalStrong, defects: tuple[LocalOrders, LocalOrders], rows: Array) -> StrongOrder:
    found, states = (LocalOrders(*(each[:, :, rows] for each in orders)) for orders in defects)
    order = found.order.copy()
    # At large coefficients, steps of the same size are coarser: an order that still increases there is extrapolated.
    order[..., 1:] = np.fmax(order, found.ahead)[..., 1:]
    (p2, q2, later2), (p1, q1, later1) = order.min(axis=(2, 3))
    means = _resolves_means(record, float(p2))
    share, typical = _state_by_state(record, states, means=means)
    now, ahead = (_strong(each[:, SELF], means=means) for each in (found.order, found.ahead))
    plateaus = found.plateau_h.max(axis=(1, 2, 3))
    return StrongOrder(
        order=float(_strong(order[:, SELF], means=means).min()),
        p2=float(p2),
        p1=float(p1) if means else np.nan,
        q2=float(q2),
        q1=float(q1) if means else np.nan,
        consistent=bool(_consistent(q2, q1, means)),
        inconsistent_share=share,
        typical=typical,
        plateau_h=float(plateaus.max() if means else plateaus[0]),
        means=means,
        ahead=float(ahead.min()),
        consistent_later=bool(_consistent(later2, later1, means)),
        turns=_turns(record, rows),
        each=tuple(zip(now.tolist(), ahead.tolist(), strict=True)),
    )


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
    size = record.mean[SELF, rows][:, group]
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


def _consistent(q2: Array, q1: Array, means: bool) -> Array:
    """Return where q2 > 0.9 and, if means are resolved, q1 > 1.4; False for orders that are NaN."""
    return (q2 > LEAST_Q2) & ((q1 > LEAST_Q1) | (not means))


def _state_by_state(record: LocalStrong, found: LocalOrders, *, means: bool) -> tuple[float, float]:
    """Return the share of inconsistent states, and the median of the orders of states, each at the worst time."""
    p2, p1 = np.fmax(found.order, found.ahead)[:, SELF].min(axis=1)
    typical = np.fmin(p2 - 0.5, p1 - 1.0) if means else p2 - 0.5
    q2, q1 = found.order[:, EM]
    wrong = ~_consistent(q2, q1, means).all(axis=0)
    by_time = int(record.times), -1
    return float(wrong.reshape(by_time).mean(axis=1).max()), float(np.median(typical.reshape(by_time), axis=1).min())
