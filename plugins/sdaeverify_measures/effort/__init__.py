"""Iterations per step for every stiffness parameter: a cost that does not depend on eps.

Two claims are supported:

``value="iterations", bound=N``
    at most N in every step, for any eps (Laurent 2022, Theorem 2.12: a contraction uniformly in eps);
``value="iterations", bound=N, share=s``
    at most N in a share s of the steps of a run, for any eps and h: unbounded noise leads to steps of any
    length.

They are tested on the costs that a scheme's steps report under names with "iterations": in whole runs at the run's
own step sizes for eps = 1e-8, ..., 10, and in a few steps of a few hundred paths at one short step size, two eps per
decade, with the same noise. A step that took more iterations refutes the first claim, a share that is significantly
larger the second. A share is that of independent paths, with Chernoff's bound, which holds for any law.

A mean that grows as eps tends to 0 for eps < h/100 refutes either claim. There a step is nearly that of the
limit, so a count that still grows by half an iteration has no bound, even if it is below N in the sample.

Step sizes with more than one in a hundred steps without a root for some eps, and coarser ones, are excluded. A
scheme that reports no iterations is not tested.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import Array, Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    NOT_PROBED,
    Bound,
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
    finding,
    judge_claim,
    packed,
    unpacked,
    why_not_claimed,
)
from sdaeverify.numerics import chernoff

from .._members import member, why_not_family
from .iterations import MOST, Iterations, RunIterations, counters, iterations, run_iterations

PROBED, ALONG = "iterations", "run iterations"
METHOD = Method("iterations of steps along runs and at fixed h", 3)
STIFF = 0.01
# Allowed growth of the mean over all eps < STIFF h, and its excess in standard errors that refutes.
GROWTH, ERRORS = 0.5, 4.0
FAILED = 0.01
UNREPORTED = "its steps report no iterations: nothing is known of the claim"


class Effort(Measure):
    """Uniform boundedness in eps of the number of iterations."""

    name: ClassVar[str] = "effort"
    lengthy: ClassVar[bool] = True
    value_of: ClassVar[str] = "iterations a step"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "without_root": "share of the steps without root",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "eps": "stiffness parameter",
        "most": "most iterations of a step",
        "without_root": "share of the steps without root",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no family, no claim, or the scheme's own reason."""
        if reason := why_not_family(scheme, problem) or why_not_claimed(scheme, problem, self.name):
            return reason
        return scheme.refuses(member(scheme.view_of(problem)))

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the iterations; empty if the scheme reports none."""
        if not counters(scheme, member(view)):
            return Tally()
        few = packed(PROBED, iterations(scheme, view, settings.seed))
        return few.merge(packed(ALONG, run_iterations(scheme, view, settings.steps, settings.seed)))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each counter, and its means."""
        names = counters(evidence.scheme, member(evidence.view))
        few = unpacked(PROBED, Iterations, evidence.tally)
        along = unpacked(ALONG, RunIterations, evidence.tally)
        if not names:
            unreported = Opinion(Verdict.ERROR, Reason(UNREPORTED))
            return Judgement((finding(coverage(evidence, self.name, PROBED), unreported),), ())
        if few is None or along is None:
            return NOT_PROBED
        counted = [_Counter(name, few, along, index) for index, name in enumerate(names)]
        findings = tuple(_finding(evidence, each) for each in counted)
        return Judgement(findings, tuple(row for each in counted for row in _levels(each)))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Effort()]


class _Counter(NamedTuple):
    # Evidence on one counter: in a few steps, along runs, and its row in both.
    name: str
    few: Iterations
    along: RunIterations
    row: int

    @property
    def mean(self) -> Array:
        return np.asarray(self.few.mean[self.row])

    @property
    def sound(self) -> slice:
        # The step sizes finer than each one with too many steps without a root for some eps.
        bad = np.flatnonzero((self.along.failed > FAILED).any(axis=0))
        return slice(int(bad[-1]) + 1 if len(bad) else 0, None)

    @property
    def most(self) -> float:
        along = self.along.most[self.row][:, self.sound]
        return float(np.fmax(self.few.most[self.row].max(), along.max(initial=0.0)))

    @property
    def failed(self) -> float:
        # The largest share of steps without a root at sound step sizes; at the finest one if none is sound.
        along = self.along.failed[:, self.sound]
        return float(max(self.few.failed.max(), along.max() if along.size else self.along.failed[:, -1].max()))

    def share(self, count: int) -> Array:
        """Return the share of steps that took more than `count`, for each eps and step size."""
        return np.asarray(self.along.above[self.row][:, self.sound, min(count, MOST - 1)])


def _finding(evidence: Evidence, counted: _Counter) -> Finding:
    covered = coverage(evidence, Effort.name, counted.name)
    opinion = judge_claim(covered, lambda claim: _opinion(evidence, claim.value, counted), {PROBED})
    return finding(
        covered,
        opinion,
        estimate=float(counted.mean.max()),
        low=float(counted.mean.min()),
        high=counted.most,
        method=METHOD,
        details={"without_root": counted.failed},
    )


def _opinion(evidence: Evidence, claim: Bound, counted: _Counter) -> Opinion:
    figures = Reason(_figures(counted))
    if refuted := _growth_in_eps(counted):
        return Opinion(Verdict.REFUTED, Reason.of(refuted, figures))
    always = claim.share == 1.0
    if always and counted.most > claim.most:
        return Opinion(
            Verdict.REFUTED,
            Reason.of(f"{counted.most:.0f} iterations in a step, at most {claim.most:g} are claimed", figures),
        )
    failed = counted.failed
    if failed > FAILED or not np.isfinite(counted.mean).all():
        return Opinion(
            Verdict.INCONCLUSIVE,
            Reason(f"{100.0 * failed:.3g} % of the steps have no root, at most {100.0 * FAILED:.2g} % are allowed"),
        )
    if always:
        return Opinion(Verdict.VERIFIED, figures)
    return _share_opinion(evidence.level, counted, int(claim.most), 1.0 - claim.share)


def _share_opinion(level: float, counted: _Counter, most: int, allowed: float) -> Opinion:
    """Judge the shares of steps that took more, each of them a mean over independent paths."""
    shares, paths = counted.share(most), counted.along.paths[:, counted.sound]
    p = chernoff(shares, allowed, paths)
    worst = np.unravel_index(shares.argmax(), shares.shape)
    where = f"eps = {counted.along.eps[worst[0]]:.0e}, h = {counted.along.h[counted.sound][worst[1]]:.3g}"
    share = f"more than {most} iterations in {100.0 * shares[worst]:.3g} % of the steps ({where})"
    reason = Reason.of(f"{share}, {100.0 * allowed:.3g} % allowed", _figures(counted))
    if np.min(p, initial=1.0, where=shares > allowed) * p.size <= level:
        return Opinion(Verdict.REFUTED, reason)
    if np.all((shares < allowed) & (p <= level)):
        return Opinion(Verdict.VERIFIED, reason)
    return Opinion(Verdict.INCONCLUSIVE, reason.then(f"{int(paths.min())} paths do not decide"))


def _figures(counted: _Counter) -> str:
    sizes = len(counted.along.h[counted.sound])
    most = f"never more than {counted.most:.0f}" + (f" at {sizes + 1} step sizes" if sizes else "")
    return f"{counted.mean.max():.2f} on average at h = {float(counted.few.h):.3g}, {most}"


def _growth_in_eps(counted: _Counter) -> str:
    """Return a text if the mean grows towards eps = 0 over the stiff part of the grid; empty if it does not."""
    few = counted.few
    stiff = np.flatnonzero(few.eps < STIFF * float(few.h))
    if len(stiff) < 2:
        return ""
    ends = stiff[[0, -1]]
    growth, error = -float(np.diff(counted.mean[ends])[0]), float(np.hypot(*few.error[counted.row][ends]))
    return (
        f"{growth:.2f} more iterations for eps = {few.eps[0]:.0e} than for eps = h/100, {GROWTH:g} are allowed"
        if growth > GROWTH + ERRORS * error
        else ""
    )


def _levels(counted: _Counter) -> Iterator[LevelFinding]:
    few, along, index = counted.few, counted.along, counted.row
    columns = (few.eps, few.mean[index], few.error[index], few.most[index], few.failed)
    for eps, mean, error, most, failed in zip(*columns, strict=True):
        details = {"eps": float(eps), "most": float(most), "without_root": float(failed)}
        yield LevelFinding(counted.name, None, float(mean), float(error), details, float(few.h))
    for (i, j), mean in np.ndenumerate(along.above[index].sum(axis=-1)):
        details = {"eps": float(along.eps[i]), "most": float(along.most[index, i, j])}
        details |= {"without_root": float(along.failed[i, j])}
        yield LevelFinding(counted.name, None, float(mean), float("nan"), details, float(along.h[j]))
