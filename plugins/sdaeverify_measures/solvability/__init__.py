"""Solvability: existence of an admissible root in each step.

One claim is supported:

``every h``
    for any step size, and from any admissible state (Lindner & Stroot 2017, Theorem 3.4).

It is tested on one step at 19 step sizes from 1e-6 to 1e3, two per decade, at a cloud of states and at its points
with velocities scaled from 1 to 1e8, without noise and with an increment of three standard deviations in each
component (T1). One step without a root, or with a state that is not finite, refutes it; so does one on a path of the
run. The share of paths with a step without a root is reported at each step size of the run, with the interval of
Clopper and Pearson. It depends on the problem's horizon and start, so no claim is about it, and no slope is fitted to
it.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import nan
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import Claim, Increment, Parts, Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    Coverage,
    Evidence,
    Finding,
    Judgement,
    LevelFinding,
    Measure,
    Method,
    Opinion,
    PathTests,
    Reason,
    Snapshot,
    Tally,
    Verdict,
    coverage,
    finding,
    group_sums,
    guard,
    judge_claim,
    local_doubt,
    local_opinion,
    packed,
    unpacked,
    why_not_claimed,
)
from sdaeverify.numerics import clopper_pearson, norm
from sdaeverify.probing import OneStep

from .root_scan import RootScan, root_scan

ROOT, SHARE = "root", "paths without root"
EVERY_H = "every h"
PROBED = "roots"
METHODS = {1: Method("roots of one step", 1), 3: Method("steps along paths", 3)}
FEW_STEPS = 64


class Solvability(Measure):
    """Existence of a root in every step, and the share of paths with a step without one."""

    name: ClassVar[str] = "solvability"
    truths: ClassVar[frozenset[str]] = frozenset()
    value_of: ClassVar[str] = "share of paths without a root"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "class": "what the value is",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "ci_low": "lower end of the interval of the share",
        "ci_high": "upper end of the interval of the share",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: steps that solve no equation."""
        view = scheme.view_of(problem)
        if view is None:
            return "the problem has no view of the scheme's form"
        h, l = view.horizon / FEW_STEPS, view.noise_dim
        zeros, areas = np.zeros((l, 2)), np.zeros((l * (l - 1) // 2, 2))
        noise = view.add_past(h, Increment(zeros, zeros, K=zeros, A=areas))
        with np.errstate(all="ignore"):
            result = scheme.prepare(view, h)(scheme.start(view, 2, h), 0.0, noise)
        return "its steps cannot fail: they solve no equation" if result.failed is None else ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> "PathCount":
        """Return an observer that counts paths, so that they are simulated; failures are counted with the steps."""
        return PathCount(parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the outcome of one step for a wide range of step sizes, if there is a claim."""
        if why_not_claimed(scheme, view, self.name) or OneStep(scheme, view).why_not_probed():
            return Tally()
        return packed(PROBED, root_scan(scheme, view))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding on the claim, if there is one, and one on the shares, with their levels."""
        shares = [_share(evidence, level) for level in range(evidence.settings.levels)]
        covered = coverage(evidence, Solvability.name, ROOT)
        findings = [_of_shares(shares, covered.gap)]
        if covered.claim is not None:
            findings.insert(0, _of_claim(evidence, shares, covered))
        return Judgement(tuple(findings), tuple(_levels(shares)))


class PathCount:
    """Counts the paths by groups."""

    def __init__(self, parts: Parts, settings: Settings) -> None:
        self.wanted: Sequence[frozenset[int]] = [frozenset()] * settings.levels
        self.paths = next(iter(parts.values())).shape[-1]

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Ignore the snapshot."""

    def tally(self) -> Tally:
        """Return the number of paths of each group."""
        return Tally(sums={"paths": group_sums(np.ones(self.paths))})


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Solvability()]


class Share(NamedTuple):
    """The share of the paths with a step without a root at one level, with its interval."""

    h: float
    value: float
    low: float
    high: float


def _share(evidence: Evidence, level: int) -> Share:
    hits, paths = int(evidence.health.sums["without_root"][level]), evidence.paths
    low, high = clopper_pearson(hits, paths, evidence.settings.confidence)
    return Share(evidence.step_sizes[level], hits / paths, low, high)


def _of_claim(evidence: Evidence, shares: Sequence[Share], covered: Coverage) -> Finding:
    def judge(claim: Claim) -> Opinion:
        # One step without a root is a counterexample, however rare, so there is no sampling error.
        met = any(share.value for share in shares)
        tests = PathTests(1.0, 0.0 if met else 1.0, Reason(_share_text(shares)))
        return guard(_by_scan(evidence), tests, evidence)._replace(p_verified=nan, p_refuted=nan)

    opinion = judge_claim(covered, judge, {EVERY_H})
    return finding(covered, opinion, method=METHODS[opinion.tier])


def _by_scan(evidence: Evidence) -> Opinion:
    scan = unpacked(PROBED, RootScan, evidence.tally)
    if scan is None:
        text = "one step cannot be probed, and no sample shows that all steps have a root"
        return local_doubt(text)
    if found := where_no_root(evidence.view, scan):
        return local_opinion(Verdict.REFUTED, found)
    count, h = scan.x.shape[1], scan.h
    text = f"at all {len(h)} step sizes from {h[0]:.3g} to {h[-1]:.3g} and {count} states"
    return local_opinion(Verdict.VERIFIED, f"a root {text} ({_farthest(evidence.view, scan)})")


def where_no_root(view: Any, scan: RootScan) -> str:
    """Return a text on steps without a root or with states that are not finite; empty if all steps succeeded."""
    for what, bad in (("no root", scan.failed), ("not finite", scan.lost)):
        if bad.any():
            size = int(np.argmax(bad.any(axis=0)))
            state = int(np.argmax(bad[:, size]))
            sizes = f"{what} at {np.count_nonzero(bad.any(axis=0))} of {len(scan.h)} step sizes"
            parts = view.parts(view.state(scan.x[:, state : state + 1]))
            return f"{sizes}, the smallest h = {scan.h[size]:.3g} where {_sizes(parts)}"
    return ""


def _sizes(parts: Parts) -> str:
    return ", ".join(f"|{name}| = {norm(part)[0]:.3g}" for name, part in parts.items())


def _farthest(view: Any, scan: RootScan) -> str:
    parts = view.parts(view.state(scan.x))
    return ", ".join(f"|{name}| up to {norm(part).max():.3g}" for name, part in parts.items())


def _of_shares(shares: Sequence[Share], gap: Reason) -> Finding:
    worst = max(shares, key=lambda share: share.value)
    return Finding(
        quantity=SHARE,
        verdict=Verdict.OUT_OF_SCOPE,
        reason=Reason.of(_share_text(shares), gap),
        estimate=worst.value,
        low=worst.low,
        high=worst.high,
        method=METHODS[3],
        details={"class": "share of paths"},
    )


def _share_text(shares: Sequence[Share]) -> str:
    met = [f"{share.value:.3g} at h = {share.h:.3g}" for share in shares if share.value]
    return (
        f"share of paths that meet a step without root {', '.join(met)}"
        if met
        else f"no path without root at {len(shares)} step sizes"
    )


def _levels(shares: Sequence[Share]) -> Iterator[LevelFinding]:
    for level, share in enumerate(shares):
        yield LevelFinding(SHARE, level, share.value, 0.0, {"ci_low": share.low, "ci_high": share.high})
