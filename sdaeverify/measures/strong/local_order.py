"""What the local strong order says of a claim."""

import numpy as np

from ...contracts.finding import Kind, Opinion, Verdict
from ...probe.local.strong_order import ACCURACY, StrongOrder
from ..judge import local_doubt, local_opinion

# How much the next order may differ from the last one for an order to be missed.
SETTLED = 0.1
# An order below its claim at few states that rises by more with a level is that of a layer which steps still miss.
RISING = 2.0 * ACCURACY


def judge_strong(
    order: StrongOrder, claim: float, tolerance: float = 0.1, *, margin: float = 0.0, sharp: bool = True
) -> Opinion:
    """Compare a local order with a claimed least strong order.

    Parameters
    ----------
    order : StrongOrder
    claim : float
    tolerance : float
        How far below the claim the order may be.
    margin : float
        That of the claim: where it is wider than `tolerance`, an order between the two decides nothing.
    sharp : bool
        Whether the scheme's local order is its global one; if not, a low local order decides nothing, and
        consistency is asked of a step from where the scheme itself has gone.

    Returns
    -------
    Opinion
        Refuted as inconsistent only where most states are, at some time.
    """
    figures = f"p2 = {order.p2:.3f}, p1 = {order.p1:.3f}, q2 = {order.q2:.3f}, q1 = {order.q1:.3f}"
    unknown = np.isnan([order.q2, order.q1 if order.means else order.q2]).any()
    if not unknown and (not order.consistent or order.inconsistent_share > 0.5):
        return _inconsistent(order, claim - tolerance, figures, sharp=sharp)
    if unknown or np.isnan(order.order):
        return local_doubt(
            f"no local order: the map is not finite or a solver's tolerance hides its defects; {figures}"
        )
    text = f"local order {order.order:.3f}, claimed {claim}; {figures}"
    if order.order < claim - tolerance:
        within = order.order >= claim - margin
        doubt = local_doubt(f"{text}; within the margin {margin:g}")
        return doubt if within else _too_low(order, claim - tolerance, text, sharp=sharp)
    if order.ahead < claim - tolerance:
        return local_doubt(f"{text}; still falling, to {order.ahead:.3f}")
    void = f"; void below h = {order.plateau_h:.2g}" if order.plateau_h else ""
    if not order.means:
        return local_doubt(f"{text}; means are not resolved{void}")
    return local_opinion(Verdict.VERIFIED, f"local order {order.order:.3f}{void}")


def _inconsistent(order: StrongOrder, bound: float, figures: str, *, sharp: bool) -> Opinion:
    text = f"one step does not follow the equation at {order.inconsistent_share:.0%} of the states; {figures}"
    if order.inconsistent_share > 0.5 and not order.consistent:
        if not sharp and order.consistent_later:
            return local_doubt(f"{text}; later steps do")
        return local_opinion(Verdict.REFUTED, text, Kind.INCONSISTENT)
    if sharp and not order.consistent and order.typical < bound:
        return local_opinion(Verdict.REFUTED, f"local order {order.typical:.3f} at most states; {text}")
    return local_doubt(text)


def _too_low(order: StrongOrder, bound: float, text: str, *, sharp: bool) -> Opinion:
    if not sharp:
        return local_doubt(f"{text}; the scheme's local order is not sharp")
    rises = order.ahead > order.order + RISING and order.typical >= bound
    if order.ahead >= bound or abs(order.ahead - order.order) > SETTLED or rises:
        return local_doubt(f"{text}; still changing, to {order.ahead:.3f}")
    return local_opinion(Verdict.REFUTED, text)
