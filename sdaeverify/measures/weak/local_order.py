"""What the local weak orders say of a claim."""

import numpy as np

from ...contracts.finding import Kind, Opinion, Verdict
from ...probe.local.weak_order import WeakOrder
from ..judge import local_doubt, local_opinion

# A failure at a smaller part of the states may be a tolerance or a singular state.
MANY = 0.25


def judge_weak(order: WeakOrder, claim: float, tolerance: float = 0.25) -> Opinion:
    """Compare local orders with a claimed least weak order.

    Parameters
    ----------
    order : WeakOrder
    claim : float
    tolerance : float
        How far below the claim an order may be.

    Returns
    -------
    Opinion
        Refuted only where settled orders are too low at a quarter of the states of some time, and inconsistent if
        most states have the order 0. A defect whose leading coefficient happens to be small may change its sign on
        the way to h = 0, and its order moves still: that is left out where it is so at fewer states, for every phi.
    """
    void = f"; void below h = {order.plateau_h:.2g}" if order.plateau_h else ""
    low = order.orders < claim - tolerance
    short = low & order.settled & (order.last < claim - tolerance)
    moving = low & ~short
    if np.isnan(order.orders).all(axis=0).any() or not order.orders.size:
        return local_doubt(f"no local weak order: steps are not finite, or a tolerance hides them{void}")
    share = float(order.share(np.asarray(short.any(axis=0))))
    if share >= MANY:
        kind = Kind.INCONSISTENT if order.inconsistent_share > 0.5 else Kind.PLAIN
        return local_opinion(Verdict.REFUTED, f"{order.least(short)}, claimed {claim}{void}", kind)
    if share:
        return local_doubt(f"{order.least(short)}, claimed {claim}, at {share:.0%} of the states alone{void}")
    if order.share(moving).max() >= MANY:
        return local_doubt(f"{order.least(moving)}, claimed {claim}, still changing with h{void}")
    least = np.min(order.orders, where=order.settled & ~low, initial=np.inf)
    figure = "exact to round-off" if np.isinf(least) else f"local weak order {least:.3f}"
    left_out = f"; {moving.sum()} of {moving.size} defects change sign" if moving.any() else ""
    return local_opinion(Verdict.VERIFIED, f"{figure}{left_out}{void}")
