"""Whether a problem discriminates: nothing is verified where the controls do not come out as they must."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from ..measure import Evidence, Finding, Judgement, Verdict
from ..scheme import Claim
from .plan import Cell, ControlPlan

# Evidence on the cell of a control, from paths alone or from all tiers; None if there is none.
Controls = Callable[[Cell, bool], Evidence | None]
# Why a claim cannot be verified, from paths alone or from all tiers; empty if it can.
Doubt = Callable[[Claim, bool], str]


@dataclass(frozen=True)
class Claiming:
    """A scheme of which something else is claimed than its author claims."""

    scheme: Any
    promises: tuple[Claim, ...]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scheme, name)


def gated(finding: Finding, doubt: Doubt) -> Finding:
    """Return a finding that is verified only if the problem discriminates at the claimed order.

    Parameters
    ----------
    finding : Finding
    doubt : callable
        As `doubts` gives it.

    Returns
    -------
    Finding
    """
    claim = finding.claim
    if claim is None or isinstance(claim.value, str) or finding.verdict is Verdict.REFUTED:
        return finding
    # The margin belongs to the claim that is tested: the controls are put to the same one.
    reason = doubt(replace(claim, quantities=(), when=frozenset(), source="control"), finding.tier == 3)
    if not reason:
        return finding
    if finding.verdict is not Verdict.VERIFIED:
        return replace(finding, p_verified=1.0)
    text = f"the problem does not discriminate here: {reason}; {finding.reason}"
    return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=text, p_verified=1.0, settled=finding.tier < 3)


def doubts(plans: tuple[ControlPlan, ...], evidence: Controls) -> Doubt:
    """Return a function of a claim, and of whether paths alone decide, that says why nothing can be verified.

    It answers each question once: many findings rest on the same controls.

    Parameters
    ----------
    plans : tuple of ControlPlan
        Of one problem.
    evidence : callable

    Returns
    -------
    callable
    """

    @cache
    def doubt(claim: Claim, sampled: bool) -> str:
        declared = [plan for plan in plans if plan.control.measure == claim.measure]
        plan = next((plan for plan in declared if plan.control.order == claim.value), None)
        if plan is None:
            return f"it declares no control of {claim.measure} order {claim.value}" if declared else ""
        return plan.missing or _not_told_apart(plan, claim, evidence, sampled=sampled)

    return doubt


def _not_told_apart(plan: ControlPlan, claim: Claim, evidence: Controls, *, sampled: bool) -> str:
    assert plan.positive is not None
    assert plan.negative is not None
    positive = _verdicts(plan.positive, claim, evidence, sampled=sampled)
    negative = _verdicts(plan.negative, claim, evidence, sampled=sampled)
    if Verdict.VERIFIED not in positive or Verdict.REFUTED in positive:
        return f"the positive control {plan.control.positive} is not verified"
    return "" if Verdict.REFUTED in negative else f"the negative control {plan.control.negative} is not refuted"


def _verdicts(cell: Cell, claim: Claim, evidence: Controls, *, sampled: bool) -> set[Verdict]:
    known = evidence(cell, sampled)
    if known is None:
        return set()
    scheme: Any = Claiming(known.scheme, (claim,))
    judged: Judgement = cell.measure.judge(replace(known, scheme=scheme))
    return {finding.verdict for finding in judged.findings}
