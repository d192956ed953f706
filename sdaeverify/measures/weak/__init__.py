"""Weak order of convergence: local expectations decide, global ones guard them.

The local weak order (T1) compares one step with a reference of the semigroup for many test functions. It is guarded
by the exact propagation of moments (T2) where the problem is linear, and by mean differences along paths (T3), which
decide alone where the one-step map cannot be probed.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from ...arrays import Parts
from ...contracts.error_sizes import ErrorSizes
from ...contracts.finding import Finding, Judgement, LevelFinding, Opinion, Reason, Verdict
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ...registry.hookspecs import hookimpl
from ..error_sizes import of_means
from ..judge import FEWEST, RESOLVED, Coverage, coverage, finding, guard, leave_open, sound_levels
from ..means import MeanObserver, Means, means_of
from .mean_order import TOO_FEW, MeanOrder, mean_order
from .probe import WeakProbe, judge_probe, probe_sizes, probe_weak, weak_probe

STATE = "state"
LOST = Reason("paths are lost at the finest level")
# Fewer functionals can all be blind to the same error.
FUNCTIONALS = 3


class Weak(Measure):
    """Weak order of convergence for each observable; for the state where there is none."""

    name: ClassVar[str] = "weak"

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> MeanObserver:
        """Return the notebook for one block."""
        return MeanObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return local weak defects, and errors of propagated moments where they can be had."""
        return probe_weak(scheme, view, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each observable, and its levels."""
        means, probed = means_of(evidence), weak_probe(evidence)
        findings = [_finding(evidence, found, probed) for found in means.values()]
        findings = _enough(findings or [_of_state(evidence, probed)])
        return Judgement(tuple(findings), tuple(row for found in means.values() for row in _levels(found)))

    def error_sizes(self, evidence: Evidence) -> Mapping[str, ErrorSizes]:
        """Return mean differences along paths, and errors that are known without sampling."""
        found = means_of(evidence).values()
        return {**{means.name: of_means(evidence, means) for means in found}, **probe_sizes(evidence)}


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Weak()]


def _finding(evidence: Evidence, means: Means, probed: WeakProbe) -> Finding:
    covered = coverage(evidence, Weak.name, means.name)
    sampled = mean_order(evidence, means, covered.claim)
    opinion = _opinion(evidence, sampled, covered, probed)
    _, left_out = sound_levels(evidence.health.sums)
    confidence = evidence.settings.confidence
    low, high = sampled.slope.interval(confidence) if opinion.tier == 3 else (float("nan"), float("nan"))
    return finding(
        covered,
        opinion.plus(sampled.remark, left_out if sampled.remark == TOO_FEW else ""),
        estimate=sampled.slope.value if opinion.tier == 3 else probed.order,
        low=low,
        high=high,
        method=_method(opinion.tier, means),
        details={**probed.details, **_details(sampled, confidence)},
    )


def _opinion(evidence: Evidence, sampled: MeanOrder, covered: Coverage, probed: WeakProbe) -> Opinion:
    if covered.claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, covered.gap)
    if evidence.health.sums["lost"][-1] > 0:
        return Opinion(Verdict.DIVERGED, LOST)
    local, confirmed = judge_probe(probed, covered.claim, covered.quantity)
    # What is known at T without sampling needs no paths to show it.
    tests = sampled.tests._replace(blind=1.0) if confirmed else sampled.tests
    opinion = guard(local, tests, evidence)
    if sampled.remark == TOO_FEW and opinion.verdict is Verdict.VERIFIED:
        return Opinion(Verdict.INCONCLUSIVE, opinion.reason.then("no paths to guard it", ", but "))
    return opinion


def _of_state(evidence: Evidence, probed: WeakProbe) -> Finding:
    """Return the finding on a problem without observables: by probing, with nothing to guard it."""
    covered = coverage(evidence, Weak.name, STATE)
    opinion, _ = judge_probe(probed, covered.claim, STATE)
    if covered.claim is None or opinion is None or opinion.verdict is Verdict.INCONCLUSIVE:
        open_ = leave_open(covered, "the problem has no observables, and probing does not decide")
        return finding(covered, open_, details=probed.details)
    method = "local weak order (T1)" if opinion.tier == 1 else "moments (T2)"
    sound, remarks = sound_levels(evidence.health.sums)
    if evidence.health.sums["lost"][-1] > 0:
        opinion = Opinion(Verdict.DIVERGED, LOST)
    elif len(sound) < FEWEST and opinion.verdict is Verdict.VERIFIED:
        opinion = Opinion(Verdict.INCONCLUSIVE, opinion.reason.then(remarks, ", but "))
    return finding(covered, opinion, estimate=probed.order, method=method, details=probed.details)


def _method(tier: int, means: Means) -> str:
    pairs = "differences to the exact solution" if means.coupled else "successive differences"
    names = {1: "local weak order (T1), guarded by", 2: "moments (T2), guarded by"}
    return f"{names[tier]} {pairs}" if tier in names else f"{pairs} along paths (T3)"


def _enough(findings: list[Finding]) -> list[Finding]:
    """Verify nothing from paths alone with fewer than three informative functionals."""
    sampled = [f for f in findings if f.tier == 3 and f.verdict is Verdict.VERIFIED]
    if len(sampled) >= FUNCTIONALS:
        return findings
    doubt = f"paths alone verify with at least {FUNCTIONALS} informative functionals"
    return [f.withheld(doubt) if f in sampled else f for f in findings]


def _details(sampled: MeanOrder, confidence: float) -> dict[str, object]:
    low, high = sampled.slope.interval(confidence)
    return {
        "path_order": sampled.slope.value,
        "path_low": low,
        "path_high": high,
        "resolved": sampled.resolved,
        "informative": not sampled.remark and sampled.resolved >= RESOLVED,
    }


def _levels(means: Means) -> Iterator[LevelFinding]:
    for level in range(means.errors):
        difference, mean = means.difference(level), means.mean(level)
        details = {"mean": mean.value, "mean_std_error": mean.se, "coupled": means.coupled}
        yield LevelFinding(means.name, level, difference.value, difference.se, details)
