"""What one step says of convergence: whether it follows the equation at all."""

import numpy as np

from ...contracts.finding import Kind, Opinion, Verdict
from ...probe.local.consistency import Consistency, consistency_orders
from ..judge import local_doubt, local_opinion

NOISE, DRIFT = 0.5, 1.0
# Local orders are known to a few hundredths; no slower convergence is told from none.
SLOWEST = 0.05


def judge_consistency(record: Consistency, component: int | None = None) -> Opinion:
    """Return whether one step follows the equation in a component, or in the full state.

    Parameters
    ----------
    record : Consistency
    component : int, optional
        Its index; the full state if left out.

    Returns
    -------
    Opinion
        Refuted if it does not so at most states.
    """
    noise, drift = consistency_orders(record, component)
    wrong, known = noise < NOISE + SLOWEST, ~np.isnan(noise)
    if record.means:
        wrong, known = wrong | (drift < DRIFT + SLOWEST), known & ~np.isnan(drift)
    first, later = wrong.mean(axis=1)
    if min(first, later) > 0.5:
        figures = f"its defect is of order {noise.min():.2f}, in the mean {drift.min():.2f}"
        text = f"one step does not follow the equation at {first:.0%} of the states: {figures}"
        return local_opinion(Verdict.REFUTED, text, Kind.INCONSISTENT)
    if wrong.any():
        text = f"one step does not follow the equation at {first:.0%} of the states, later ones at {later:.0%}"
        return local_doubt(text)
    if not known.all():
        return local_doubt("whether one step follows the equation is not known at all states")
    if not record.means:
        return local_doubt("whether one step follows the equation in the mean is not resolved")
    return local_opinion(Verdict.VERIFIED, "one step follows the equation")
