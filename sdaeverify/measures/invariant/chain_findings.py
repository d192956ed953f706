"""Findings on stationary means from replicated chains (T3)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Array
from ...contracts.measure import Evidence, Finding, LevelFinding, Verdict
from ...contracts.scheme import Claim
from ...forms.truths import InvariantMean
from ...simulate.chains import CONTRACTING, GROUPS, ChainRecord
from ..judge import FEWEST, RESOLVED, WRONG, at_levels, claim_for, doubted, sound_levels
from .bias import BiasOpinion, bias_bound, sampled_bias, with_bias
from .chain_order import ChainOpinion, Sample, opinion, samples

METHOD = "paired replicated chains (T3)"

# So many verified observables end the run, whatever others may still show.
ENOUGH = 3


@dataclass(frozen=True)
class Chained:
    """One observable's evidence.

    Attributes
    ----------
    name : str
    looks : list of Sample
        At least one.
    claim : Claim or None
    no_claim : str
        Why there is none.
    opinion : ChainOpinion or None
        What the chains say of a claimed order.
    """

    name: str
    looks: list[Sample]
    claim: Claim | None
    no_claim: str
    opinion: ChainOpinion | None

    @property
    def resolved(self) -> bool:
        """Whether all differences are told from 0 at the last look."""
        return self.looks[-1].resolved


def chain_findings(evidence: Evidence, record: ChainRecord) -> list[Finding]:
    """Return a finding for each observable whose exact mean is known."""
    levels, remarks = _usable(record)
    names = [truth.observable for truth in _truths(evidence)]
    if len(record.time) == 0 or len(levels) < FEWEST:
        return [_unfitted(evidence, record, name, remarks) for name in names]
    chained = _chained(evidence, record, levels)
    findings = [_finding(evidence, record, one, chained) for one in chained]
    return [replace(found, reason=_joined(found.reason, *remarks)) for found in doubted(findings)]


def chain_levels(evidence: Evidence, record: ChainRecord) -> Iterator[LevelFinding]:
    """Yield the bias of each observable at each step size, at the last look."""
    levels, _ = _usable(record)
    if len(record.time) == 0 or len(levels) < 2:
        return
    for one in _chained(evidence, record, levels):
        errors, differences = one.looks[-1].errors, one.looks[-1].differences
        for index, h in enumerate(one.looks[-1].h):
            estimate, error = _mean(errors[:, index])
            pair = _mean(differences[:, index]) if index < differences.shape[1] else (np.nan, np.nan)
            details = {"difference": pair[0], "difference_std_error": pair[1], "fitted": True}
            yield LevelFinding(one.name, None, estimate, error, details, float(h))


def decided(findings: Sequence[Finding], record: ChainRecord) -> bool:
    """Tell whether no further look is needed: nothing is claimed, or something refuted, or enough is verified.

    An observable that shows no bias is waited for as long as the looks that are left can be expected to resolve it,
    unless enough others are verified, or as its limit looks wrong. Further looks neither make a record stationary nor
    a level sound.
    """
    verdicts = [finding.verdict for finding in findings]
    if Verdict.REFUTED in verdicts or set(verdicts) <= {Verdict.OUT_OF_SCOPE, Verdict.DIVERGED}:
        return True
    if not record.stationary or not any(finding.details for finding in findings):
        return True
    reach = 2.0 ** (float(record.planned) - len(record.time))
    waiting = {v for v, f in zip(verdicts, findings, strict=True) if _is_open(f, reach)}
    return not waiting or (Verdict.INCONCLUSIVE not in waiting and verdicts.count(Verdict.VERIFIED) >= ENOUGH)


def _is_open(finding: Finding, reach: float) -> bool:
    signal = float(str(finding.details["resolved"]))
    ordered = bias_bound(finding.claim) is None
    hopeless = ordered and signal < RESOLVED and signal * np.sqrt(reach) < RESOLVED and not finding.p_refuted < 1.0
    return finding.verdict in {Verdict.INCONCLUSIVE, Verdict.NOT_APPLICABLE} and not hopeless


def _truths(evidence: Evidence) -> list[InvariantMean]:
    return [truth for truth in evidence.view.truths if isinstance(truth, InvariantMean)]


def _usable(record: ChainRecord) -> tuple[Array, list[str]]:
    """Return the levels that can be used, and remarks on the others and on the chains."""
    levels, _ = sound_levels({"failed": record.failed + record.lost, "truncated": record.truncated})
    blown_up = {float(h) for h in (record.diverged, *record.h[record.lost > 0]) if np.isfinite(h)}
    remarks = [f"diverged at h = {', '.join(f'{h:.3g}' for h in sorted(blown_up))}"] if blown_up else []
    wrong = {"failed paths": record.failed > 0, "truncated steps": record.truncated > 0}
    remarks += [at_levels(what, where) for what, where in wrong.items() if where.any()]
    if len(record.time) and not record.stationary:
        remarks.append(f"the record does not look stationary after a burn-in of {float(record.burn_in):.3g}")
    if float(record.contraction) >= CONTRACTING:
        text = f"distance ratio {float(record.contraction):.2g}"
        remarks.append(f"chains with the same noise do not approach each other ({text}): pairing gains little")
    return levels, remarks


def _chained(evidence: Evidence, record: ChainRecord, levels: Array) -> list[Chained]:
    names = list(evidence.view.observables)
    found = []
    for truth in _truths(evidence):
        looks = samples(record, levels, names.index(truth.observable), truth.value)
        claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, "invariant", truth.observable)
        asked = claim is not None and not isinstance(claim.value, str) and bool(record.stationary)
        said = opinion(looks, claim, float(record.planned), evidence) if asked and claim else None
        found.append(Chained(truth.observable, looks, claim, no_claim, said))
    return found


def _finding(evidence: Evidence, record: ChainRecord, one: Chained, others: Sequence[Chained]) -> Finding:
    last, confidence = one.looks[-1], evidence.settings.confidence
    low, high = last.order_interval(confidence)
    found = Finding(
        quantity=one.name,
        verdict=Verdict.OUT_OF_SCOPE,
        reason=one.no_claim,
        claim=one.claim,
        estimate=last.order,
        low=low,
        high=high,
        method=METHOD,
        details=_details(record, last),
    )
    if one.claim is None:
        return found
    if (bound := bias_bound(one.claim)) is not None:
        return _bias_finding(record, found, sampled_bias(bound, one.looks, float(record.planned), evidence))
    if one.opinion is None:
        known = isinstance(one.claim.value, str)
        reason = f"this measure does not know what {one.claim.value!r} means" if known else ""
        return replace(found, verdict=Verdict.INCONCLUSIVE, reason=reason)
    verdict, reason = _opinion(evidence, record, one, others)
    p_verified = one.opinion.verified
    if verdict is Verdict.NOT_APPLICABLE or last.changes_sign():
        p_verified = np.nan
    return replace(found, verdict=verdict, reason=reason, p_verified=p_verified, p_refuted=one.opinion.refuted)


def _bias_finding(record: ChainRecord, found: Finding, said: BiasOpinion) -> Finding:
    """Return the finding on a claimed bound: verified only where all step sizes can be used, of a settled record."""
    if said.verdict is Verdict.INCONCLUSIVE:
        said = said._replace(reason=said.reason + _needed(record, said.growth))
    if said.verdict is Verdict.VERIFIED and len(_usable(record)[0]) < len(record.h):
        said = said._replace(verdict=Verdict.INCONCLUSIVE, p_verified=1.0)
    if not record.stationary:
        said = said._replace(verdict=Verdict.INCONCLUSIVE, p_verified=1.0, p_refuted=1.0)
    return with_bias(found, said)


def _opinion(evidence: Evidence, record: ChainRecord, one: Chained, others: Sequence[Chained]) -> tuple[Verdict, str]:
    said, last = one.opinion, one.looks[-1]
    assert said is not None
    assert one.claim is not None
    low, high = last.order_interval(evidence.settings.confidence)
    order = f"order {last.order:.3f}, at least {low:.3f} and at most {high:.3f}; claimed {one.claim.value}"
    left, se = _mean(last.left(float(one.claim.value)))
    off = f"limit off by {left:.1g} with standard error {se:.1g}"
    if said.refuted <= evidence.level:
        return Verdict.REFUTED, order if said.slow < said.wrong else f"{WRONG}: {off.removeprefix('limit ')}"
    if last.changes_sign():
        return _uninformative("its bias changes sign between step sizes", others, one)
    if said.verified <= evidence.level:
        return Verdict.VERIFIED, f"{order}; {off}"
    if not one.resolved:
        least = np.abs(last.signals).min()
        text = f"its bias is not seen: a mean difference is {least:.1f} standard errors"
        return _uninformative(text, others, one, _needed(record, (RESOLVED / least) ** 2 if least else np.inf))
    return Verdict.INCONCLUSIVE, _joined(order, off) + _needed(record, said.growth)


def _uninformative(reason: str, others: Sequence[Chained], one: Chained, needed: str = "") -> tuple[Verdict, str]:
    shown = [other.name for other in others if other is not one and other.resolved]
    if not shown:
        return Verdict.INCONCLUSIVE, f"{reason}{needed}"
    return Verdict.NOT_APPLICABLE, f"uninformative: {reason}, while that of {', '.join(shown)} is told"


def _needed(record: ChainRecord, growth: float) -> str:
    if not np.isfinite(growth):
        return ""
    chains = float(f"{growth * float(record.paired):.1g}")
    return f"; about {chains:.0f} chains of length {float(record.time[-1]):.3g} would decide"


def _details(record: ChainRecord, sample: Sample) -> dict[str, object]:
    local = sample.local_orders
    return {
        "local_orders": " ".join(f"{order:.2f}" for order in local),
        "leading_coefficient": sample.leading_coefficient,
        "bias": float(sample.errors[:, -1].mean()),
        "bias_std_error": _mean(sample.errors[:, -1])[1],
        "resolved": float(np.abs(sample.signals).min()),
        "chains": int(record.paired),
        "chain_length": float(record.time[-1]),
        "burn_in": float(record.burn_in),
        "contraction": float(record.contraction),
        "looks": len(record.time),
    }


def _unfitted(evidence: Evidence, record: ChainRecord, name: str, remarks: Sequence[str]) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, "invariant", name)
    verdict = Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE
    if record.lost[-1] > 0:
        verdict = Verdict.DIVERGED
    reason = _joined(f"fewer than {FEWEST} step sizes can be used", *remarks, no_claim)
    return Finding(quantity=name, verdict=verdict, reason=reason, claim=claim, method=METHOD)


def _mean(values: Array) -> tuple[float, float]:
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(GROUPS))


def _joined(*texts: str) -> str:
    return "; ".join(text for text in texts if text)
