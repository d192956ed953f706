"""Whether a problem discriminates: nothing is verified where the controls do not come out as they must.

Nor is anything refuted by paths where a scheme that is known to be right is refuted, too: it is the problem then, its
truth above all, that is wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

from ..contracts.finding import Finding, Judgement, Verdict
from ..contracts.measure import Evidence
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


class ControlEvidence(NamedTuple):
    """Evidence on the cell of a control: from paths alone, and from all tiers."""

    sampled: Evidence
    whole: Evidence


class ControlVerdicts:
    """What the controls of a problem have against verdicts on other schemes.

    Each question is answered once: many findings rest on the same controls.

    Parameters
    ----------
    plans : tuple of ControlPlan
        Of one problem.
    evidence : mapping of Cell to ControlEvidence or Objection
        On each cell of the controls that can be run, or why there is none.
    """

    def __init__(self, plans: tuple[ControlPlan, ...], evidence: Mapping[Cell, ControlEvidence | Objection]) -> None:
        self.plans, self.evidence = plans, evidence
        self.objection, self._refuted = cache(self._objection), cache(self._refuted_quantities)

    def suspicion(self, scheme: Scheme, measure: str, quantity: str) -> str:
        """Return why paths cannot refute a scheme's claim on a measure in a quantity; empty if they can."""
        known = [plan for plan in self.plans if plan.control.measure == measure and not plan.missing]
        others = [plan for plan in known if plan.positive is not None and plan.positive.scheme.label != scheme.label]
        wrong = next((plan.control for plan in others if quantity in self._refuted(plan)), None)
        return f"{wrong.positive} is refuted here, too, which has order {wrong.order}" if wrong else ""

    def _objection(self, claim: Claim, by_paths: bool) -> Objection | None:
        """Return why a claim cannot be verified, by paths alone or by all tiers; None if it can."""
        assert not isinstance(claim.value, str)
        plans = [plan for plan in reversed(self.plans) if plan.control.measure == claim.measure]
        declared = {plan.control.order: plan for plan in plans}
        asked = [declared[order] for order in deciding(declared, claim.value)]
        if not asked:
            reason = f"it declares no control of {claim.measure} order {claim.value} or more"
            return Objection(reason) if declared else None
        if asked[0].missing:
            return Objection(asked[0].missing, Verdict.ERROR if asked[0].failed else Verdict.INCONCLUSIVE)
        return self._not_told_apart(asked, claim, by_paths=by_paths)

    def _not_told_apart(self, plans: Sequence[ControlPlan], claim: Claim, *, by_paths: bool) -> Objection | None:
        """Return why the controls of the order above a claim and, if it is between two, below it do not decide it."""
        above, *below = plans
        positive = self._verdicts(above.positive, claim, by_paths=by_paths)
        if isinstance(positive, Objection):
            return positive
        if Verdict.VERIFIED not in positive or Verdict.REFUTED in positive:
            return Objection(f"the positive control {above.control.positive} is not verified")
        lower = {above.control.negative: above.negative, **{plan.control.positive: plan.positive for plan in below}}
        found = [self._verdicts(cell, claim, by_paths=by_paths) for cell in lower.values()]
        if any(Verdict.REFUTED in verdicts for verdicts in found if not isinstance(verdicts, Objection)):
            return None
        # What was not measured is not what was not refuted.
        if (unknown := next((verdicts for verdicts in found if isinstance(verdicts, Objection)), None)) is not None:
            return unknown
        if len(lower) == 1:
            return Objection(f"the negative control {above.control.negative} is not refuted")
        return Objection(f"none of the controls {', '.join(lower)} is refuted, which have lower orders")

    def _verdicts(self, cell: Cell | None, claim: Claim, *, by_paths: bool) -> set[Verdict] | Objection:
        """Return the verdicts on a control, none where it cannot be run, or why there is no evidence on it."""
        if cell is None:
            return set()
        known = self.evidence[cell]
        if isinstance(known, Objection):
            return known._replace(reason=f"its control {cell.scheme.label} {known.reason}")
        return {finding.verdict for finding in _findings(cell, claim, known.sampled if by_paths else known.whole)}

    def _refuted_quantities(self, plan: ControlPlan) -> frozenset[str]:
        """Return the quantities in which a positive control is refuted by its own order."""
        assert plan.positive is not None
        claim = Claim(measure=plan.control.measure, value=plan.control.order, source="control")
        known = self.evidence[plan.positive]
        found = () if isinstance(known, Objection) else _findings(plan.positive, claim, known.whole)
        return frozenset(finding.quantity for finding in found if finding.verdict is Verdict.REFUTED)


def heed_controls(finding: Finding, scheme: Scheme, controls: ControlVerdicts) -> Finding:
    """Return a finding that is verified only if the problem discriminates, and refuted only if it is sound.

    Parameters
    ----------
    finding : Finding
    scheme : Scheme
        That it is about.
    controls : ControlVerdicts

    Returns
    -------
    Finding
    """
    claim, by_paths = finding.claim, finding.tier == 3
    if claim is None or isinstance(claim.value, str):
        return finding
    if finding.verdict is Verdict.REFUTED:
        suspicion = controls.suspicion(scheme, claim.measure, finding.quantity) if by_paths else ""
        return _suspect(finding, suspicion) if suspicion else finding
    # The margin belongs to the claim that is tested: the controls are put to the same one.
    objection = controls.objection(replace(claim, quantities=(), when=frozenset(), source="control"), by_paths)
    if objection is None:
        return finding
    if finding.verdict is not Verdict.VERIFIED:
        return replace(finding, p_verified=1.0)
    reason, verdict = objection
    known = verdict is Verdict.INCONCLUSIVE
    doubt = f"the problem does not discriminate here: {reason}" if known else f"it cannot be verified: {reason}"
    return finding.withheld(doubt, verdict=verdict, settled=not (known and by_paths))


def _suspect(finding: Finding, reason: str) -> Finding:
    doubt = f"the truth of the problem is suspect: {reason}"
    return finding.withheld(doubt, verdict=Verdict.ERROR, p_refuted=1.0)


def _findings(cell: Cell, claim: Claim, known: Evidence) -> tuple[Finding, ...]:
    judgement: Judgement = cell.measure.judge(replace(known, claims=(claim,)))
    return judgement.findings
