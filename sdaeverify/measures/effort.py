"""Iterations a step for every stiffness parameter: cost that does not depend on eps.

One claim is known:

``at most N iterations``
    in every step, whatever eps is (Laurent 2022, Theorem 2.12: a contraction uniformly in eps).

It is put to the costs that a scheme's steps report under names with "iterations": a few steps of a few hundred paths
for eps = 1e-8, ..., 10, two a decade, at one h and on the same noise. A step that took more refutes it. So does a
mean that grows as eps tends to 0 where eps < h/100 already: there a step is all but that of the limit, and a count
that still grows by half an iteration has no bound; a sample that is below N does not show one.
"""

import re
from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from ..forms import Problem
from ..hookspecs import hookimpl
from ..measure import Evidence, Finding, Judgement, LevelFinding, Measure, Verdict
from ..probe.iterations import Iterations, counters, iterations
from ..probe.stiffness import FEW_PATHS, FEW_STEPS, member, no_family
from ..scheme import Claim, Scheme
from ..settings import Settings
from ..tally import Tally, packed, unpacked
from ..verdicts import Opinion, claim_for

PROBED = "iterations"
METHOD = "iterations of steps at fixed h (T3)"
STIFF = 0.01
# The mean may grow by so much over all eps < STIFF h, beyond so many standard errors.
GROWTH, ERRORS = 0.5, 4.0
FAILED = 0.01


class Effort(Measure):
    """Whether the number of iterations is bounded uniformly in eps."""

    name: ClassVar[str] = "effort"
    lengthy: ClassVar[bool] = True

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Refuse what has no family or no claim, and schemes that report no iterations."""
        if reason := no_family(scheme, problem, self.name):
            return reason
        one = member(scheme.view_of(problem))
        reason = scheme.refuses(one)
        return reason or ("" if counters(scheme, one) else "its steps report no iterations")

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the iterations."""
        return packed(PROBED, iterations(scheme, view, settings.seed))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each counter, and its means."""
        record = unpacked(PROBED, Iterations, evidence.tally)
        if record is None:
            return Judgement((Finding(quantity="", verdict=Verdict.INCONCLUSIVE, reason="not probed"),), ())
        names = counters(evidence.scheme, member(evidence.view))
        findings = tuple(_finding(evidence, record, index, name) for index, name in enumerate(names))
        return Judgement(findings, tuple(row for i, name in enumerate(names) for row in _levels(record, i, name)))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Effort()]


def _finding(evidence: Evidence, record: Iterations, index: int, name: str) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, Effort.name, name)
    opinion = Opinion(Verdict.OUT_OF_SCOPE, no_claim) if claim is None else _opinion(claim, record, index)
    return Finding(
        quantity=name,
        verdict=opinion.verdict,
        reason=opinion.reason,
        claim=claim,
        estimate=float(record.mean[index].max()),
        low=float(record.mean[index].min()),
        high=float(record.most[index].max()),
        method=METHOD,
        details={"without_root": float(record.failed.max())},
    )


def _opinion(claim: Claim, record: Iterations, index: int) -> Opinion:
    said = re.fullmatch(r"at most (\d+) iterations", str(claim.value))
    if said is None:
        return Opinion(Verdict.INCONCLUSIVE, f"this measure does not know what {claim.value!r} means")
    mean, most, eps = record.mean[index], record.most[index], record.eps
    figures = f"{mean.min():.2f} to {mean.max():.2f} on average, {most.max():.0f} at most, h = {float(record.h):.3g}"
    reason = f"{figures}, {len(eps) * FEW_STEPS * FEW_PATHS} steps with eps from {eps[0]:.0e} to {eps[-1]:.0e}"
    if np.any(most > int(said[1])):
        worst = int(np.nanargmax(most))
        return Opinion(Verdict.REFUTED, f"{most[worst]:.0f} iterations in a step at eps = {eps[worst]:.0e}; {reason}")
    growth, error = _growth(record, index)
    if growth > GROWTH + ERRORS * error:
        return Opinion(Verdict.REFUTED, f"{growth:.2f} more for eps = {eps[0]:.0e} than for eps = h/100; {reason}")
    if record.failed.max() > FAILED or not np.isfinite(mean).all():
        share = f"{100.0 * record.failed.max():.2g} per cent of the steps have no root; {reason}"
        return Opinion(Verdict.INCONCLUSIVE, share)
    return Opinion(Verdict.VERIFIED, reason)


def _growth(record: Iterations, index: int) -> tuple[float, float]:
    """Return by how much the mean grows over the stiff half of the grid, towards eps = 0, with its standard error."""
    stiff = np.flatnonzero(record.eps < STIFF * float(record.h))
    if len(stiff) < 2:
        return 0.0, 0.0
    ends = stiff[[0, -1]]
    mean, error = record.mean[index][ends], record.error[index][ends]
    return float(mean[0] - mean[1]), float(np.hypot(*error))


def _levels(record: Iterations, index: int, name: str) -> Iterator[LevelFinding]:
    columns = (record.eps, record.mean[index], record.error[index], record.most[index], record.failed)
    for eps, mean, error, most, failed in zip(*columns, strict=True):
        details = {"eps": float(eps), "most": float(most), "without_root": float(failed)}
        yield LevelFinding(name, None, float(mean), float(error), details, float(record.h))
