"""Whether a problem discriminates: nothing is verified where the controls do not come out as they must."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ..measure import Evidence, Finding, Judgement, Verdict
from ..scheme import Claim
from .plan import Cell, ControlPlan

# Evidence on the cell of a control, from paths alone or from all tiers; None if there is none.
Controls = Callable[[Cell, bool], Evidence | None]


@dataclass(frozen=True)
class Claiming:
    """A scheme of which something else is claimed than its author claims."""

    scheme: Any
    promises: tuple[Claim, ...]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scheme, name)


def gated(finding: Finding, plans: tuple[ControlPlan, ...], evidence: Controls) -> Finding:
    """Return a finding that is verified only if the problem discriminates at the claimed order.

    Parameters
    ----------
    finding : Finding
        Of a measure that these controls are for.
    plans : tuple of ControlPlan
        Of the same measure; empty if the problem declares none for it.
    evidence : callable

    Returns
    -------
    Finding
    """
    claim = finding.claim
    if not plans or claim is None or isinstance(claim.value, str) or finding.verdict is Verdict.REFUTED:
        return finding
    doubt = _doubt(claim, plans, evidence, sampled=finding.tier == 3)
    if not doubt:
        return finding
    if finding.verdict is not Verdict.VERIFIED:
        return replace(finding, p_verified=1.0)
    reason = f"the problem does not discriminate here: {doubt}; {finding.reason}"
    settled = finding.tier < 3
    return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason, p_verified=1.0, settled=settled)


def _doubt(claim: Claim, plans: tuple[ControlPlan, ...], evidence: Controls, *, sampled: bool) -> str:
    plan = next((plan for plan in plans if plan.control.order == claim.value), None)
    if plan is None:
        return f"it declares no control of {claim.measure} order {claim.value}"
    if plan.missing:
        return plan.missing
    assert plan.positive is not None
    assert plan.negative is not None
    # The margin belongs to the claim that is tested: the controls are put to the same one.
    asked = replace(claim, quantities=(), when=frozenset(), source="control")
    positive = _verdicts(plan.positive, asked, evidence, sampled=sampled)
    negative = _verdicts(plan.negative, asked, evidence, sampled=sampled)
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
