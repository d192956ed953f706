"""Asymptotic preservation: the rate at which a scheme tends to its limit eps = 0 at a fixed step size.

The exponents of eps in |X_n^eps - X_n^0| and |zeta(X_n^eps)|, Laurent (2022), Theorem 2.9, of the largest distance in
a few steps with the same noise, in the root mean square over paths; with noise 1/2, without it 1. The slope is fitted
for eps far below h; its interval is the jackknife's. A distance that is rounding for every eps satisfies a claim of
any order.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Claim, Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    NOT_PROBED,
    Evidence,
    Finding,
    Judgement,
    LevelFinding,
    Measure,
    Method,
    Opinion,
    Reason,
    Tally,
    Verdict,
    coverage,
    decide,
    finding,
    judge_claim,
    order_tests,
    packed,
    unpacked,
    why_not_claimed,
)

from .._members import member, why_not_family
from .stiff_limit import LimitDistances, Slope, limit_distances, limit_slopes

PROBED = "limit"
METHOD = Method("distances at fixed h on the same noise", 3)
STILL = "without noise"
# Largest share of paths that may be excluded.
FAILED = 0.01


class StiffLimits(Measure):
    """Exponents of eps in the distance from the limit and in the constraint."""

    name: ClassVar[str] = "limits"
    follows: ClassVar[str] = "paths"
    lengthy: ClassVar[bool] = True
    level_columns: ClassVar[Mapping[str, str]] = {
        "eps": "stiffness parameter",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no family, no claim, or the scheme does not run at eps = 0."""
        if reason := why_not_family(scheme, problem) or why_not_claimed(scheme, problem, self.name):
            return reason
        reason = scheme.refuses(member(scheme.view_of(problem), 0.0))
        return f"not run in the limit eps = 0: {reason}" if reason else ""

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the distances at fixed h for small eps."""
        return packed(PROBED, limit_distances(scheme, view, settings.seed))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for both distances, with noise and without, and the distances."""
        record = unpacked(PROBED, LimitDistances, evidence.tally)
        if record is None:
            return NOT_PROBED
        found = limit_slopes(record)
        findings = tuple(_finding(evidence, record, name, slope) for name, slope in found.items())
        return Judgement(
            findings, tuple(row for name, slope in found.items() for row in _levels(record, name, slope))
        )


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [StiffLimits()]


def _finding(evidence: Evidence, record: LimitDistances, name: str, slope: Slope) -> Finding:
    covered = coverage(evidence, StiffLimits.name, name)
    opinion = judge_claim(covered, lambda claim: _opinion(evidence, record, claim, slope))._replace(settled=True)
    low, high = slope.estimate.interval(evidence.settings.confidence)
    return finding(covered, opinion, estimate=slope.estimate.value, low=low, high=high, method=METHOD)


def _opinion(evidence: Evidence, record: LimitDistances, claim: Claim, slope: Slope) -> Opinion:
    if record.failed > FAILED:
        share = f"a step has no root on {100.0 * float(record.failed):.3g} % of the paths, {100.0 * FAILED:g} % may"
        return Opinion(Verdict.INCONCLUSIVE, Reason(share))
    if np.isnan(slope.estimate.value):
        return Opinion(Verdict.INCONCLUSIVE, Reason("no slope: distances are not finite, or round-off, for most eps"))
    if np.isinf(slope.estimate.value):
        return Opinion(Verdict.VERIFIED, Reason(f"no distance beyond round-off at all {len(record.eps)} eps"))
    tests = order_tests(claim, slope.estimate, evidence, of="in eps, of the distance to the limit,")
    return decide(tests._replace(growth=np.inf), evidence)


def _levels(record: LimitDistances, name: str, slope: Slope) -> Iterator[LevelFinding]:
    for eps, distance in zip(record.eps, slope.distances, strict=True):
        yield LevelFinding(name, None, float(distance), 0.0, {"eps": float(eps)}, float(record.h))
