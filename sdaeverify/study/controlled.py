"""Whether a problem discriminates: nothing is verified where the controls do not come out as they must.

Nor is anything refuted by paths where a scheme that is known to be right is refuted, too: it is the problem then, its
truth above all, that is wrong.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from ..contracts.measure import Evidence, Finding, Judgement, Verdict
from ..contracts.scheme import Claim, Scheme
from ..forms.controls import deciding
from .plan import Cell, ControlPlan


class Objection(NamedTuple):
    """Why a claim cannot be verified.

    Attributes
    ----------
    reason : str
    verdict : Verdict
        Inconclusive where the controls do not come out as they must; an error or not run where that is not known.
    """

    reason: str
    verdict: Verdict = Verdict.INCONCLUSIVE


# Evidence on the cell of a control, from paths alone or from all tiers, or why there is none.
Controls = Callable[[Cell, bool], Evidence | Objection]
# Why a claim cannot be verified, from paths alone or from all tiers; None if it can.
Doubt = Callable[[Claim, bool], Objection | None]
# Why paths cannot refute a scheme's claim on a measure in a quantity; empty if they can.
Suspicion = Callable[[Scheme, str, str], str]


class Doubts(NamedTuple):
    """What the controls of a problem have against a verdict.

    Attributes
    ----------
    verified : callable
    refuted : callable
    """

    verified: Doubt
    refuted: Suspicion


@dataclass(frozen=True)
class Claiming:
    """A scheme of which something else is claimed than its author claims."""

    scheme: Any
    promises: tuple[Claim, ...]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scheme, name)


def gated(finding: Finding, scheme: Scheme, doubts: Doubts) -> Finding:
    """Return a finding that is verified only if the problem discriminates, and refuted only if it is sound.

    Parameters
    ----------
    finding : Finding
    scheme : Scheme
        That it is about.
    doubts : Doubts

    Returns
    -------
    Finding
    """
    claim = finding.claim
    if claim is None or isinstance(claim.value, str):
        return finding
    if finding.verdict is Verdict.REFUTED:
        suspicion = doubts.refuted(scheme, claim.measure, finding.quantity) if _by_paths(finding) else ""
        return _suspected(finding, suspicion) if suspicion else finding
    # The margin belongs to the claim that is tested: the controls are put to the same one.
    objection = doubts.verified(replace(claim, quantities=(), when=frozenset(), source="control"), _by_paths(finding))
    if objection is None:
        return finding
    if finding.verdict is not Verdict.VERIFIED:
        return replace(finding, p_verified=1.0)
    reason, verdict = objection
    known = verdict is Verdict.INCONCLUSIVE
    text = f"the problem does not discriminate here: {reason}" if known else f"it cannot be verified: {reason}"
    settled = not (known and _by_paths(finding))
    return replace(finding, verdict=verdict, reason=f"{text}; {finding.reason}", p_verified=1.0, settled=settled)


def doubts(plans: tuple[ControlPlan, ...], evidence: Controls) -> Doubts:
    """Return what the controls of a problem have against verdicts.

    Each question is answered once: many findings rest on the same controls.

    Parameters
    ----------
    plans : tuple of ControlPlan
        Of one problem.
    evidence : callable

    Returns
    -------
    Doubts
    """

    @cache
    def doubt(claim: Claim, sampled: bool) -> Objection | None:
        assert not isinstance(claim.value, str)
        declared = {plan.control.order: plan for plan in reversed(plans) if plan.control.measure == claim.measure}
        asked = [declared[order] for order in deciding(declared, claim.value)]
        if not asked:
            reason = f"it declares no control of {claim.measure} order {claim.value} or more"
            return Objection(reason) if declared else None
        if asked[0].missing:
            return Objection(asked[0].missing, Verdict.ERROR if asked[0].failed else Verdict.INCONCLUSIVE)
        return _not_told_apart(asked, claim, evidence, sampled=sampled)

    @cache
    def refuted(plan: ControlPlan) -> frozenset[str]:
        assert plan.positive is not None
        control = plan.control
        claim = Claim(measure=control.measure, value=control.order, source="control")
        known = evidence(plan.positive, False)
        found = () if isinstance(known, Objection) else _findings(plan.positive, claim, known)
        return frozenset(finding.quantity for finding in found if finding.verdict is Verdict.REFUTED)

    def suspicion(scheme: Scheme, measure: str, quantity: str) -> str:
        known = [plan for plan in plans if plan.control.measure == measure and not plan.missing]
        others = [plan for plan in known if plan.positive is not None and plan.positive.scheme.label != scheme.label]
        wrong = next((plan.control for plan in others if quantity in refuted(plan)), None)
        return f"{wrong.positive} is refuted here, too, which has order {wrong.order}" if wrong else ""

    return Doubts(doubt, suspicion)


def _by_paths(finding: Finding) -> bool:
    return finding.tier == 3


def _suspected(finding: Finding, reason: str) -> Finding:
    text = f"the truth of the problem is suspect: {reason}; {finding.reason}"
    return replace(finding, verdict=Verdict.ERROR, reason=text, p_verified=1.0, p_refuted=1.0)


def _not_told_apart(
    plans: Sequence[ControlPlan], claim: Claim, evidence: Controls, *, sampled: bool
) -> Objection | None:
    """Tell why the controls of the order above a claim and, if it lies between two, below it do not decide it."""
    above, *below = plans
    positive = _verdicts(above.positive, claim, evidence, sampled=sampled)
    if isinstance(positive, Objection):
        return positive
    if Verdict.VERIFIED not in positive or Verdict.REFUTED in positive:
        return Objection(f"the positive control {above.control.positive} is not verified")
    lower = {above.control.negative: above.negative, **{plan.control.positive: plan.positive for plan in below}}
    found = [_verdicts(cell, claim, evidence, sampled=sampled) for cell in lower.values()]
    if any(Verdict.REFUTED in verdicts for verdicts in found if not isinstance(verdicts, Objection)):
        return None
    # What was not measured is not what was not refuted.
    if (unknown := next((verdicts for verdicts in found if isinstance(verdicts, Objection)), None)) is not None:
        return unknown
    if len(lower) == 1:
        return Objection(f"the negative control {above.control.negative} is not refuted")
    return Objection(f"none of the controls {', '.join(lower)} is refuted, which have lower orders")


def _verdicts(cell: Cell | None, claim: Claim, evidence: Controls, *, sampled: bool) -> set[Verdict] | Objection:
    """Return the verdicts on a control, none where it cannot be run, or why there is no evidence on it."""
    if cell is None:
        return set()
    known = evidence(cell, sampled)
    if isinstance(known, Objection):
        return known._replace(reason=f"its control {cell.scheme.label} {known.reason}")
    return {finding.verdict for finding in _findings(cell, claim, known)}


def _findings(cell: Cell, claim: Claim, known: Evidence) -> tuple[Finding, ...]:
    scheme: Any = Claiming(known.scheme, (claim,))
    judged: Judgement = cell.measure.judge(replace(known, scheme=scheme))
    return judged.findings
