"""Consistency of one step with the equation, which errors along paths do not show if a wrong limit is near."""

import numpy as np

from ...contracts.finding import Kind, Opinion, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Scheme
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Problem
from ...probe.local.consistency import Consistency, consistency, consistency_orders
from ...probe.local.delay_links import remove_delay, why_not_algebraic
from ...probe.local.strong_defects import why_not_local_order
from ...probe.step.one_step import OneStep
from ...verdicts.opinions import local_doubt, local_opinion
from .errors import STATE

PROBED = "local consistency"
# Theorem: local orders above 1/2 and 1 are needed for convergence (Milstein 1988, Theorem 1).
NOISE, DRIFT = 0.5, 1.0
# Local orders are accurate to a few hundredths, so slower convergence is indistinguishable from none.
# Chosen.
SLOWEST = 0.05


def probe_consistency(scheme: Scheme, view: Problem) -> Tally:
    """Return the defects of one step, if it can be probed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    """
    pair = remove_delay(scheme, view)
    if why_not_algebraic(scheme, view) or why_not_local_order(*pair):
        return Tally()
    return packed(PROBED, consistency(*pair))


def consistency_opinions(evidence: Evidence) -> dict[str, Opinion]:
    """Return the opinions on the consistency of one step, by component and for the state; empty if not probed."""
    record = unpacked(PROBED, Consistency, evidence.tally)
    if record is None:
        return {}
    names = enumerate(OneStep(*remove_delay(evidence.scheme, evidence.view)).names)
    return {**{name: judge_consistency(record, i) for i, name in names}, STATE: judge_consistency(record)}


def judge_consistency(record: Consistency, component: int | None = None) -> Opinion:
    """Judge whether one step follows the equation in a component, or in the full state.

    Parameters
    ----------
    record : Consistency
    component : int, optional
        Its index; the full state if omitted.

    Returns
    -------
    Opinion
        Refuted if the step does not follow it at most of the states.
    """
    noise, drift = consistency_orders(record, component)
    wrong = (noise < NOISE + SLOWEST) | (drift < DRIFT + SLOWEST)
    known = ~(np.isnan(noise) | np.isnan(drift))
    first, later = wrong.mean(axis=1)
    if min(first, later) > 0.5:
        figures = f"its error is RMS ~ h^{noise.min():.2f} (above 0.55 needed), mean ~ h^{drift.min():.2f} (1.05)"
        text = f"one step does not follow the equation at {first:.0%} of the states: {figures}"
        return local_opinion(Verdict.REFUTED, text, Kind.INCONSISTENT)
    if wrong.any():
        text = f"one step does not follow the equation at {first:.0%} of the states, a later one at {later:.0%}"
        return local_doubt(text, against=later > 0.0)
    if not known.all():
        return local_doubt("whether one step follows the equation is not known at all states")
    return local_opinion(Verdict.VERIFIED, "one step follows the equation")
