"""Consistency of one step with the equation, which errors along paths do not show if a wrong limit is near."""

from ...contracts.finding import Kind, Opinion, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Scheme
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Problem
from ...probe.local.consistency import Consistency, consistency
from ...probe.local.delay_links import remove_delay, why_not_algebraic
from ...probe.step.one_step import OneStep
from ...verdicts.opinions import local_opinion
from .errors import STATE

PROBED = "local consistency"


def probe_consistency(scheme: Scheme, view: Problem) -> Tally:
    """Return the deviation of short steps from the equation, if they can be compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    """
    found = None if why_not_algebraic(scheme, view) else consistency(*remove_delay(scheme, view))
    return Tally() if found is None else packed(PROBED, found)


def consistency_opinions(evidence: Evidence) -> dict[str, Opinion]:
    """Return the opinions on the consistency of one step, by component and for the state; empty if not compared."""
    record = unpacked(PROBED, Consistency, evidence.tally)
    if record is None:
        return {}
    names = tuple(OneStep(*remove_delay(evidence.scheme, evidence.view)).names)
    found = (judge_departure(record.departure(names, index)) for index in (*range(len(names)), None))
    return dict(zip((*names, STATE), found, strict=True))


def judge_departure(departure: str) -> Opinion:
    """Judge whether one step follows the equation.

    A deviation refutes whether or not the scheme declares that its local order is its global one, as it does before
    any measure: see `violation`.

    Parameters
    ----------
    departure : str
        How it departs from the equation, or an empty string.
    """
    if not departure:
        return local_opinion(Verdict.VERIFIED, "one step follows the equation")
    return local_opinion(Verdict.REFUTED, departure, Kind.INCONSISTENT)
