"""Findings on stationary means from replicated chains (T3)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Order
from ...contracts.finding import Finding, Kind, LevelFinding, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...forms.truths import InvariantMean
from ...simulate.chains import (
    CONTRACTING,
    GROUPS,
    MOST_FIRST,
    MOST_WIDE,
    WIDE_OF_PAIRED,
    ChainPlan,
    ChainRecord,
    chains_of,
)
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.fitted_levels import FEWEST, name_wrong, sound_levels
from ...verdicts.opinions import diverged, finding, judge_claim, rounded_up
from ...verdicts.path_tests import RESOLVED, order_in
from ...verdicts.rules import withhold_in_doubt
from ..resolution import stationary_resolution
from .bias import UNKNOWN_BIAS, StationaryBias, bias_bound, bias_of_chains, with_bias
from .chain_order import BiasSample, ChainTests, chain_tests, samples

METHOD = Method("paired replicated chains", 3)

# Number of verified observables that ends the run, even if others could still be decided.
# Size: of a run; the other observables stay undecided.
ENOUGH = 3


@dataclass(frozen=True)
class ObservableBias:
    """Evidence on one observable.

    Attributes
    ----------
    covered : Coverage
        The observable, with its claim.
    looks : list of BiasSample
        At least one.
    tests : ChainTests or None
        Tests of a claimed order.
    """

    covered: Coverage
    looks: list[BiasSample]
    tests: ChainTests | None

    @property
    def name(self) -> str:
        """Name of the observable."""
        return self.covered.quantity

    @property
    def resolved(self) -> bool:
        """Whether all differences are significantly different from 0 at the last look."""
        return self.looks[-1].resolved


def chain_findings(evidence: Evidence, record: ChainRecord) -> list[Finding]:
    """Return a finding for each observable with a known exact mean."""
    levels, remarks = _usable(record)
    names = [truth.observable for truth in _truths(evidence)]
    if len(record.time) == 0 or len(levels) < FEWEST:
        return [_without_levels(evidence, record, name, remarks) for name in names]
    biases = _biases(evidence, record, levels)
    findings = withhold_in_doubt([_finding(evidence, record, one, biases) for one in biases])
    return [replace(found, reason=Reason.of(found.reason, *remarks)) for found in findings]


def chain_levels(evidence: Evidence, record: ChainRecord) -> Iterator[LevelFinding]:
    """Yield the bias of each observable at each step size, at the last look."""
    levels, _ = _usable(record)
    if len(record.time) == 0 or len(levels) < 2:
        return
    for one in _biases(evidence, record, levels):
        errors, differences = one.looks[-1].errors, one.looks[-1].differences
        for index, h in enumerate(one.looks[-1].h):
            estimate, error = _mean(errors[:, index])
            pair = _mean(differences[:, index]) if index < differences.shape[1] else (np.nan, np.nan)
            details = {"difference": pair[0], "difference_std_error": pair[1], "fitted": True}
            yield LevelFinding(one.name, None, estimate, error, details, float(h))


def is_decided(findings: Sequence[Finding], record: ChainRecord) -> bool:
    """Return whether no further look is needed: there is no claim, one is refuted, or enough are verified.

    An observable without significant bias is waited for as long as the remaining looks are expected to resolve it,
    unless enough others are verified, or if its limit looks wrong. Further looks make neither a record stationary nor
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
    """Return the usable levels, and remarks on the other levels and on the chains."""
    levels, _ = sound_levels({"failed": record.failed + record.lost, "truncated": record.truncated})
    blown_up = _blown_up(record)
    remarks = [f"diverged at h = {', '.join(f'{h:.3g}' for h in blown_up)}"] if blown_up else []
    remarks += name_wrong(record.failed, record.truncated)
    if len(record.time) and not record.stationary:
        remarks.append(f"chains are not stationary after a burn-in of {float(record.burn_in):.3g}")
    if float(record.contraction) >= CONTRACTING:
        ratio = f"distance ratio {float(record.contraction):.2g}"
        remarks.append(f"chains of the same noise do not approach each other ({ratio})")
    return levels, remarks


def _blown_up(record: ChainRecord) -> list[float]:
    """Return the step sizes at which chains diverged, the smallest first."""
    return sorted({float(h) for h in (record.diverged, *record.h[record.lost > 0]) if np.isfinite(h)})


def _biases(evidence: Evidence, record: ChainRecord, levels: Array) -> list[ObservableBias]:
    names = list(evidence.view.observables)
    found = []
    for truth in _truths(evidence):
        looks = samples(record, levels, names.index(truth.observable), truth.value)
        covered = coverage(evidence, "invariant", truth.observable)
        value = covered.claim and covered.claim.value
        tests = None
        if isinstance(value, Order) and record.stationary:
            tests = chain_tests(looks, value, float(record.planned), evidence)
        found.append(ObservableBias(covered, looks, tests))
    return found


def _finding(
    evidence: Evidence, record: ChainRecord, one: ObservableBias, others: Sequence[ObservableBias]
) -> Finding:
    last, bound = one.looks[-1], bias_bound(one.covered.claim)
    low, high = last.order_interval(evidence.settings.confidence)
    # An order is not judged while a record does not look stationary; the remarks state this.
    unsettled = Opinion(Verdict.INCONCLUSIVE)
    opinion = judge_claim(
        one.covered, lambda claim: _opinion(evidence, record, one, claim.value, others) if one.tests else unsettled
    )
    details = _details(record, last)
    found = finding(one.covered, opinion, estimate=last.order, low=low, high=high, method=METHOD, details=details)
    seen = stationary_resolution(*last.known_errors(evidence.settings.confidence), abs(last.exact), one.covered.claim)
    found = replace(found, resolution=seen)
    if bound is None:
        return found
    return _bias_finding(record, found, *bias_of_chains(bound, one.looks, float(record.planned), evidence))


def _bias_finding(record: ChainRecord, found: Finding, bias: StationaryBias, opinion: Opinion) -> Finding:
    """Return the finding on a claimed bound; verified only for a stationary record with all step sizes usable."""
    if opinion.verdict is Verdict.INCONCLUSIVE:
        opinion = opinion.plus(_ask_for_chains(record, bias.growth))
    if opinion.verdict is Verdict.VERIFIED and len(_usable(record)[0]) < len(record.h):
        opinion = opinion._replace(verdict=Verdict.INCONCLUSIVE, p_verified=1.0)
    if not record.stationary:
        opinion = opinion._replace(verdict=Verdict.INCONCLUSIVE, p_verified=1.0, p_refuted=1.0)
    sizes = _blown_up(record)
    if not sizes or opinion.verdict is Verdict.REFUTED:
        return with_bias(found, bias, opinion)
    # The chains that are left at other step sizes have a bias within the bound: it is not what decides.
    return with_bias(found, UNKNOWN_BIAS, _refute_by_divergence(sizes))


def _refute_by_divergence(sizes: Sequence[float]) -> Opinion:
    """Return the opinion on a bound, refuted by step sizes at which chains diverge.

    A chain that can diverge does so eventually: there is no stationary mean then, and none within a bound. An
    order is about small steps, a bound about every step size that is probed, so no step is too coarse for it.
    """
    text = "chains diverge at h = {sizes}, so that no stationary mean exists; the bound is claimed at every step size"
    reason = Reason(text, numbers={"sizes": ", ".join(f"{h:.3g}" for h in sizes)})
    return Opinion(Verdict.REFUTED, reason, p_verified=1.0, p_refuted=0.0)


def _opinion(
    evidence: Evidence,
    record: ChainRecord,
    one: ObservableBias,
    claim: Order,
    others: Sequence[ObservableBias],
) -> Opinion:
    last, tests = one.looks[-1], one.tests
    assert tests is not None
    low, high = last.order_interval(evidence.settings.confidence)
    order = order_in(last.order, low, high, claim)
    left, se = _mean(last.remainder(claim.least))
    off = "off by {left:.1g} (standard error {se:.1g})"
    limit, wrong = (
        Reason(text, kind, {"left": left, "se": se})
        for text, kind in ((f"limit {off}", Kind.PLAIN), (f"{Kind.WRONG_LIMIT}: {off}", Kind.WRONG_LIMIT))
    )
    if tests.refuted <= evidence.level:
        verdict, reason = Verdict.REFUTED, order if tests.slow < tests.wrong else wrong
    elif last.changes_sign():
        verdict, reason = _uninformative("bias changes sign between step sizes", others, one)
    elif tests.verified <= evidence.level:
        verdict, reason = Verdict.VERIFIED, order.then(limit)
    elif not one.resolved:
        least = np.abs(last.signals).min()
        noise = "bias below sampling noise ({standard_errors:.1f} standard errors; {needed:g} needed)"
        text = Reason(noise, numbers={"standard_errors": least, "needed": RESOLVED})
        # Below one standard error, the number of chains that would resolve it cannot be predicted.
        needed = _ask_for_chains(record, (RESOLVED / least) ** 2, "resolve it") if least >= 1.0 else ""
        verdict, reason = _uninformative(text, others, one, needed)
    else:
        verdict, reason = Verdict.INCONCLUSIVE, order.then(limit).then(_ask_for_chains(record, tests.growth))
    void = verdict is Verdict.NOT_APPLICABLE or last.changes_sign()
    return Opinion(verdict, reason, p_verified=np.nan if void else tests.verified, p_refuted=tests.refuted)


def _uninformative(
    text: Reason | str, others: Sequence[ObservableBias], one: ObservableBias, needed: Reason | str = ""
) -> tuple[Verdict, Reason]:
    shown = [other.name for other in others if other is not one and other.resolved]
    if not shown:
        return Verdict.INCONCLUSIVE, Reason.of(text, needed)
    return Verdict.NOT_APPLICABLE, Reason(f"not informative: {text}, while that of {', '.join(shown)} is resolved")


def _ask_for_chains(record: ChainRecord, growth: float, aim: str = "decide") -> Reason:
    if not (np.isfinite(growth) and growth > 1.0):
        return Reason()
    needed, (most, _) = growth * float(record.paired), chains_of(MOST_WIDE)
    figures = {"length": float(record.time[-1]), "most": most, "aim": aim}
    if needed > most:
        text = "more than {most} chains, the maximum of --paths, would be needed up to t = {length:.3g}"
        return Reason(text, Kind.MORE_PATHS, figures)
    figures |= {"chains": rounded_up(needed), "option": rounded_up(WIDE_OF_PAIRED * needed)}
    text = "about {chains} chains up to t = {length:.3g} would {aim} (--paths {option})"
    return Reason(text, Kind.MORE_PATHS, figures)


def _details(record: ChainRecord, sample: BiasSample) -> dict[str, object]:
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


def _without_levels(evidence: Evidence, record: ChainRecord, name: str, remarks: Sequence[str]) -> Finding:
    covered = coverage(evidence, "invariant", name)
    verdict = Verdict.INCONCLUSIVE if covered.claim else Verdict.OUT_OF_SCOPE
    text = _too_dear(evidence, record) or f"fewer than {FEWEST} step sizes can be used"
    opinion = diverged(Opinion(verdict, Reason.of(text, *remarks, covered.gap)), record.lost[-1])
    return finding(covered, opinion, method=METHOD)


def _too_dear(evidence: Evidence, record: ChainRecord) -> str:
    """Return the cost of the chains if it is too large (for half the step size if the coarsest diverged), or ""."""
    relaxation, h = evidence.view.relaxation_time, float(record.h[0]) * (0.5 if record.lost[0] > 0 else 1.0)
    if len(record.time) or (steps := ChainPlan(h, relaxation, 0).first_look) <= MOST_FIRST:
        return ""
    taken = f"{steps} steps of h = {h:.2g} and below (relaxation time {relaxation:.3g})"
    bound = f"at most {MOST_FIRST} are allowed, which suffice from h = {h * steps / MOST_FIRST:.2g} on"
    return f"chains would take {taken}; {bound}"


def _mean(values: Array) -> tuple[float, float]:
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(GROUPS))
