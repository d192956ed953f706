"""Uniform accuracy: the order in h of the largest error over all stiffness parameters, on one family of problems.

The problem is rebuilt, its truths included, with eps = 1e-8, ..., 10, and the supremum over this grid is examined as
a function of h; see `uniform_errors` for why no slope is fitted at fixed eps. If errors are exact for all
eps, no paths are sampled:

``weak``
    Each first and second moment at T, if problem and step are linear: two eps per decade.
``strong``
    (E |X_N - X(T)|^2)^{1/2} on one Brownian path, if both are linear and the noise is additive.
``invariant``
    Stationary means by the transition operator, if the family has a chart and known means: one eps per decade.

Otherwise the weak and the strong error are sampled, all members and step sizes with the same noise; see
`paired_members` and `paired_findings`. A claim that names the following quantity is tested on it, too:

``one step``
    The local weak error, for every eps at the beginning of a step; see `uniform_errors`. Each first and second moment
    has its own order, the last one above rounding, and an extrapolated one. A moment with both orders below the
    claim, minus its margin, refutes it.

A claim is that of Laurent (2022), Theorem 2.7, or of Proposition 3.3: an order, from which the claim's margin is
subtracted.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Array, Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    NOT_PROBED,
    Coverage,
    Evidence,
    Finding,
    Judgement,
    Kind,
    LevelFinding,
    Measure,
    Method,
    Opinion,
    Order,
    Reason,
    Tally,
    Verdict,
    coverage,
    finding,
    judge_claim,
    local_doubt,
    packed,
    unpacked,
    why_not_claimed,
)
from sdaeverify.probing import (
    invariant_observables,
    last_orders,
    why_not_linear_pair,
    why_not_moments,
    why_not_operator,
)

from .._members import member, why_not_family
from .paired_findings import STRONG, WEAK, paired_findings
from .paired_members import PairedErrors, paired_errors
from .uniform_errors import (
    MEMBER_LEVELS,
    MEMBER_RATIOS,
    Supremum,
    UniformDefects,
    UniformErrors,
    invariant_suprema,
    moment_suprema,
    strong_suprema,
    suprema,
    uniform_defects,
    why_not_uniform_defects,
)

INVARIANT, PAIRED = "invariant", "paired"
METHODS = {
    WEAK: Method("supremum over eps of errors of moments", 2),
    STRONG: Method("supremum over eps of distances by moments", 2),
    INVARIANT: Method("supremum over eps of errors of stationary means by the transition operator", 2),
}
MEASURE, ONE_STEP = "uniformity", "one step"
METHOD = Method("one step against two half steps, supremum over eps", 1)
FEWEST = 3


class Uniformity(Measure):
    """Orders of suprema over eps."""

    name: ClassVar[str] = "uniformity"
    follows: ClassVar[str] = "paths"
    lengthy: ClassVar[bool] = True
    budgeted: ClassVar[bool] = True
    detail_columns: ClassVar[Mapping[str, str]] = {
        "functional": "of which the supremum is taken",
        "worst_eps": "eps at which it is taken, at the finest step size",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "functional": "what the error is of",
        "low": "least that the estimate can be",
        "high": "most that the estimate can be",
        "worst_eps": "eps at which the estimate is largest",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no family, no claim, or an atomic law if errors must be sampled."""
        if reason := why_not_family(scheme, problem) or why_not_claimed(scheme, problem, self.name):
            return reason
        one = member(scheme.view_of(problem))
        if scheme.refuses(one):
            return scheme.refuses(one)
        return _why_not_paired(scheme, one) if _inexact(scheme, one) else ""

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the errors that need no sampling, or errors on a share of the run's paths."""
        evidence = _errors(scheme, view, settings)
        if why_not_uniform_defects(scheme, view):
            return evidence
        return evidence.merge(packed(ONE_STEP, uniform_defects(scheme, view)))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each kind of error, and its suprema."""
        found = _of_errors(evidence)
        covered, record = one_step_coverage(evidence), unpacked(ONE_STEP, UniformDefects, evidence.tally)
        if covered.claim is None:
            return found
        if record is None:
            reason = why_not_uniform_defects(evidence.scheme, evidence.view) or "the step cannot be probed"
            open_ = finding(covered, local_doubt(reason))
            return found._replace(findings=(*found.findings, open_))
        names = [name.replace("x_", "dx_") for name in _names(evidence, WEAK)]
        levels = (*found.levels, *one_step_levels(record, names))
        return Judgement((*found.findings, one_step_finding(covered, record, names)), levels)

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Return the finding on the local weak error, uniformly in eps, along a random family of problems."""
        evidence = Evidence.of_one_step(scheme, view)
        covered = one_step_coverage(evidence)
        if covered.claim is None or why_not_family(scheme, view):
            return ()
        if reason := why_not_uniform_defects(scheme, view):
            return (finding(covered, local_doubt(reason)),)
        names = [name.replace("x_", "dx_") for name in _names(evidence, WEAK)]
        return (one_step_finding(covered, uniform_defects(scheme, view, MEMBER_LEVELS, MEMBER_RATIOS), names),)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Uniformity()]


def _errors(scheme: Scheme, view: Any, settings: Settings) -> Tally:
    one, steps = member(view), settings.steps
    if _inexact(scheme, one):
        return packed(PAIRED, paired_errors(scheme, view, settings))
    if why_not_moments(scheme, one):
        return packed(INVARIANT, invariant_suprema(scheme, view, steps))
    evidence = packed(WEAK, moment_suprema(scheme, view, steps))
    if why_not_linear_pair(scheme, one):
        return evidence
    return evidence.merge(packed(STRONG, strong_suprema(scheme, view, steps)))


def _of_errors(evidence: Evidence) -> Judgement:
    paired = unpacked(PAIRED, PairedErrors, evidence.tally)
    if paired is not None:
        findings, levels = zip(*paired_findings(evidence, paired), strict=True)
        return Judgement(findings, tuple(row for rows in levels for row in rows))
    records = ((name, unpacked(name, UniformErrors, evidence.tally)) for name in METHODS)
    found = [(name, record) for name, record in records if record is not None]
    if not found:
        return NOT_PROBED
    findings = tuple(_finding(evidence, name, record) for name, record in found)
    return Judgement(findings, tuple(row for name, record in found for row in _levels(evidence, name, record)))


def _inexact(scheme: Scheme, one: Problem) -> bool:
    """Return whether neither moments nor stationary means are exact for every eps."""
    return bool(why_not_moments(scheme, one) and (why_not_operator(scheme, one) or not invariant_observables(one)))


def _why_not_paired(scheme: Scheme, one: Problem) -> str:
    if scheme.law.bounded:
        return f"nothing is exact, and step sizes share no paths, as {scheme.law.name} increments are not Brownian"
    return "" if one.observables else "nothing is exact, and the problem has no observables"


def _finding(evidence: Evidence, name: str, record: UniformErrors) -> Finding:
    covered = coverage(evidence, Uniformity.name, name)
    named = list(zip(_names(evidence, name), suprema(record), strict=True))
    resolved = [each for each in named if each[1].resolved]
    label, worst = min(resolved, key=lambda each: each[1].order, default=(named[0]))
    opinion = judge_claim(covered, lambda claim: _opinion(claim.value, record, named))
    return finding(
        covered,
        opinion._replace(tier=2),
        estimate=worst.order,
        low=worst.least,
        high=worst.most,
        method=METHODS[name],
        details={"functional": label, "worst_eps": float(worst.worst[-1])},
    )


def _opinion(claim: Order, record: UniformErrors, named: list[tuple[str, Supremum]]) -> Opinion:
    if not record.applies:
        reason = Reason("the step is not linear, has no root somewhere or leaves the chart")
        return Opinion(Verdict.INCONCLUSIVE, reason)
    bound = claim.floor
    below = [each for each in named if each[1].resolved and each[1].most < bound]
    if below:
        return Opinion(Verdict.REFUTED, _order(record, claim, *min(below, key=lambda each: each[1].order)))
    open_ = [label for label, found in named if not found.resolved and found.seen]
    if open_:
        return Opinion(Verdict.INCONCLUSIVE, Reason(f"the error of {', '.join(open_)} is below the noise"))
    resolved = [each for each in named if each[1].resolved]
    least = min(resolved, key=lambda each: each[1].order, default=None)
    reason = (
        _order(record, claim, *least) if least else Reason(f"no error beyond round-off at {len(record.h)} step sizes")
    )
    reason = Reason.of(reason, *(_list_unresolved(label, found) for label, found in named if len(found.left_out)))
    if all(len(found.left_out) for _, found in named):
        return Opinion(Verdict.INCONCLUSIVE, reason.then("none is known for every eps"))
    if all(found.least >= bound for _, found in resolved):
        return Opinion(Verdict.VERIFIED, reason)
    return Opinion(
        Verdict.INCONCLUSIVE,
        reason.then(
            f"known within [{min(f.least for _, f in resolved):.2f}, {max(f.most for _, f in resolved):.2f}]"
        ),
    )


def _list_unresolved(label: str, found: Supremum) -> str:
    return f"{label} is below the noise for eps = {', '.join(f'{eps:.3g}' for eps in found.left_out)}"


def _order(record: UniformErrors, claim: Order, label: str, found: Supremum) -> Reason:
    last = int(np.flatnonzero(np.isfinite(found.high)).max(initial=0))
    if np.isinf(found.value[-1]):
        where = f"h = {record.h[-1]:.3g}, eps = {found.worst[-1]:.3g}"
        return Reason(f"the error of {label} is not bounded: infinite at {where}")
    where = f"{found.value[last]:.2g} at h = {record.h[last]:.3g}, eps = {found.worst[last]:.3g}"
    text = "largest error of {label} over all eps ~ h^{order:.2f}, {where}; {bar}"
    return Reason(text, Kind.ORDER, {"order": found.order, "label": label, "where": where, "bar": claim.bar})


def _names(evidence: Evidence, name: str) -> list[str]:
    if name == STRONG:
        return ["x"]
    if name == INVARIANT:
        return [f"E {observable}" for observable in invariant_observables(member(evidence.view))]
    d = member(evidence.view).dimension
    second = (f"E x_{i + 1} x_{j + 1}" for i, j in zip(*np.triu_indices(d), strict=True))
    return [*(f"E x_{i + 1}" for i in range(d)), *second]


def _levels(evidence: Evidence, name: str, record: UniformErrors) -> Iterator[LevelFinding]:
    for label, found in zip(_names(evidence, name), suprema(record), strict=True):
        for h, value, low, high, eps in zip(record.h, *found[:4], strict=True):
            details = {"functional": label, "low": float(low), "high": float(high), "worst_eps": float(eps)}
            yield LevelFinding(name, None, float(value), 0.0, details, float(h))


def one_step_coverage(evidence: Evidence) -> Coverage:
    """Return the claim about one step; a claim about errors along paths only does not count."""
    covered = coverage(evidence, MEASURE, ONE_STEP)
    named = covered.claim is not None and ONE_STEP in covered.claim.quantities
    return covered if named else covered._replace(claim=None)


def one_step_finding(covered: Coverage, record: UniformDefects, names: list[str]) -> Finding:
    """Return the finding on the order of the local weak error, uniformly in eps.

    Parameters
    ----------
    covered : Coverage
        With a claim.
    record : UniformDefects
    names : list of str
        Names of the moments.
    """
    found = [_orders(record, *pair) for pair in ((record.halves, record.floor), (record.euler, record.nearly))]
    order, ahead = (np.concatenate(parts) for parts in zip(*found, strict=True))
    against = [f"{name} against {what}" for what in ("two half steps", "Euler's step") for name in names]
    worst = int(np.where(np.isnan(order), -np.inf, np.fmax(order, ahead)).argmin())

    def judge(claim: Any) -> Opinion:
        figures = {"order": order[worst], "functional": against[worst], "bar": claim.value.bar}
        reason = Reason("one-step order {order:.2f} of {functional}; {bar}", Kind.ORDER, figures)
        verdict, remark = _verdict(claim.value.floor, record, order, ahead)
        return Opinion(verdict, reason.then(remark), 1)

    opinion = judge_claim(covered, judge, tier=1)
    return finding(
        covered, opinion, estimate=float(order[worst]), method=METHOD, details={"functional": against[worst]}
    )


def one_step_levels(record: UniformDefects, names: list[str]) -> Iterator[LevelFinding]:
    """Yield the largest difference from two half steps of each moment at each step size."""
    for name, sizes, ratios in zip(names, record.halves, record.ratio, strict=True):
        for h, size, ratio in zip(record.h, sizes, ratios, strict=True):
            details = {"functional": name, "worst_eps": float(ratio * h)}
            yield LevelFinding(ONE_STEP, None, float(size), 0.0, details, float(h))


def _orders(record: UniformDefects, size: Array, floor: Array) -> tuple[Array, Array]:
    rooted = record.failed == 0.0
    if rooted.sum() < FEWEST:
        return np.full(len(size), np.nan), np.full(len(size), np.nan)
    found = last_orders(record.h[rooted], size[:, rooted], floor[:, rooted], np.ones(int(rooted.sum())))
    return found.order, found.ahead


def _verdict(bound: float, record: UniformDefects, order: Array, ahead: Array) -> tuple[Verdict, str]:
    """Return the verdict, and a remark to append to the figures."""
    if np.any(np.maximum(order, ahead) < bound):
        return Verdict.REFUTED, ""
    if np.all(np.minimum(order, ahead) >= bound):
        return Verdict.VERIFIED, ""
    lost = int(np.sum(record.failed > 0.0))
    return Verdict.INCONCLUSIVE, f"steps without root at {lost} step sizes" if lost else "still changing with h"
