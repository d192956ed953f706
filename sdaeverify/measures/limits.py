"""Asymptotic preservation: how fast a scheme tends to its limit eps = 0 at a fixed step size.

The exponents of eps in |X_n^eps - X_n^0| and |zeta(X_n^eps)|, Laurent (2022), Theorem 2.9, of the largest distance in
a few steps on the same noise, in the root mean square over paths; with noise 1/2, without it 1. The slope is fitted
where eps is far below h; its interval is the jackknife's. What is rounding for every eps keeps a claim of any order.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from ..contracts.claimed import Order
from ..contracts.finding import Finding, Judgement, LevelFinding, Method, Opinion, Reason, Verdict
from ..contracts.measure import Evidence, Measure
from ..contracts.scheme import Claim, Scheme
from ..contracts.settings import Settings
from ..contracts.tally import Tally, packed, unpacked
from ..forms import Problem
from ..probe.stiffness.members import member, no_family
from ..probe.stiffness.stiff_limit import LimitDistances, Slope, limit_distances, limit_slopes
from ..registry.hookspecs import hookimpl
from ..verdicts.coverage import coverage, no_claim
from ..verdicts.opinions import NOT_PROBED, decide, finding
from ..verdicts.path_tests import order_tests

PROBED = "limit"
METHOD = Method("distances at fixed h on the same noise", 3)
STILL = "without noise"
# No more paths may be left out.
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
        """Refuse what has no family or no claim, and schemes that cannot be run at eps = 0."""
        if reason := no_family(scheme, problem) or no_claim(scheme, problem, self.name):
            return reason
        reason = scheme.refuses(member(scheme.view_of(problem), 0.0))
        return f"the scheme cannot be run in the limit: {reason}" if reason else ""

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the distances."""
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
    opinion = Opinion(Verdict.OUT_OF_SCOPE, covered.gap)
    if covered.claim is not None:
        opinion = _opinion(evidence, record, covered.claim, slope)._replace(settled=True)
    low, high = slope.estimate.interval(evidence.settings.confidence)
    return finding(covered, opinion, estimate=slope.estimate.value, low=low, high=high, method=METHOD)


def _opinion(evidence: Evidence, record: LimitDistances, claim: Claim, slope: Slope) -> Opinion:
    if record.failed > FAILED:
        share = f"{100.0 * float(record.failed):.2g} per cent of the paths met a step without root"
        return Opinion(Verdict.INCONCLUSIVE, Reason(share))
    if np.isnan(slope.estimate.value):
        return Opinion(Verdict.INCONCLUSIVE, Reason("distances are not finite, or rounding for many eps"))
    if np.isinf(slope.estimate.value) and isinstance(claim.value, Order):
        return Opinion(Verdict.VERIFIED, Reason("rounding for every eps"))
    return decide(order_tests(claim, slope.estimate, evidence)._replace(growth=np.inf), evidence)


def _levels(record: LimitDistances, name: str, slope: Slope) -> Iterator[LevelFinding]:
    for eps, distance in zip(record.eps, slope.distances, strict=True):
        yield LevelFinding(name, None, float(distance), 0.0, {"eps": float(eps)}, float(record.h))
