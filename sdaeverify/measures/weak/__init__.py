"""Weak order of convergence: local expectations decide, global ones guard them.

The local weak order (T1) compares one step with a reference of the semigroup for many test functions. It is guarded
by the exact propagation of moments (T2) if the problem is linear, and by mean differences along paths (T3), which
decide alone if the one-step map cannot be probed.

These differences are paired: with the exact solution on the same path if it is known, else between successive step
sizes. The latter do not detect a wrong limit, so the finest level is also compared with a known expectation.
Their order is a slope of log2 |mean difference|.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...arrays import Array, Parts
from ...contracts.claimed import Order
from ...contracts.finding import SAMPLED, Finding, Judgement, Kind, LevelFinding, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import Claim, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ...numerics.statistics import EPS, RISING, Estimate, correct_for_skewness
from ...probe.operator.functional_orders import leading_columns
from ...registry.hookspecs import hookimpl
from ...verdicts.coverage import Coverage, claim_for, coverage
from ...verdicts.fitted_levels import FEWEST, FITTED, sound_levels_of
from ...verdicts.opinions import ask_to_resolve, diverged, finding, guard, judge_claim, leave_open, local_doubt
from ...verdicts.path_tests import (
    COARSE,
    RESOLVED,
    SUSPECT,
    PathTests,
    ask_for_truth,
    hold_back,
    order_resolution,
    order_tests,
    resolve_order,
    unlike,
    with_sample,
)
from ...verdicts.rules import withhold
from ..means import MeanObserver, Means, known_mean, means_of
from ..resolution import weak_resolution
from .probe import TOLERANCE, WeakProbe, judge_probe, member_finding, probe_weak, weak_probe
from .size import bound_findings, constant_columns, probe_bounds

STATE = "state"
LOST = "{lost:.0f} paths are not finite at the finest step size"
# Fewer functionals may all be insensitive to the same error.
# Chosen.
FUNCTIONALS = 3
METHODS = {1: Method("local weak order", 1), 2: Method("moments", 2)}
TOO_FEW = "a slope needs {fewest} step sizes, got {levels}: use smaller steps"
ROUNDING = "no error beyond round-off at {levels} step sizes, hence no slope"
CHANGES_SIGN = Reason("the error changes sign between step sizes, hence no slope")
# Bound of the error at the finest level for a h^p + b h^(p+1), as a multiple of the last difference over 2^p - 1.
# Theorem: elementary, with r = (2^(p+1) - 1)/(2^p - 1) the multiple is (1 + s)/(1 + r s), s = b h/a: at most 2 for
# s >= -1/(2 r - 1), that is, while the second term has not taken a fifth (p = 1) of the first.
SLACK = 2.0
# No scheme converges more slowly in law than it does along paths.
# Theorem: |E f(x) - E f(y)| <= L E|x - y|, and the least strong order is 1/2.
SLOWEST = 0.5
SLOWER = "too far from the limit for the claim"

UNKNOWN = Estimate(float("nan"), float("nan"))

# Distance of a mean from the known limit, and the error of the latter.
Off = tuple[Estimate, float]


class MeanOrder(NamedTuple):
    """Order of one observable along paths.

    Attributes
    ----------
    slope : Estimate
    levels : ndarray of int
        Differences that are fitted.
    resolved : float
        Smallest ratio of a difference to its standard error.
    tests : PathTests
    remark : Reason
        Why the observable is not used; empty if it is.
    share : Estimate
        Share of the error at the finest step that belongs to a term of half an order less than claimed; NaN if
        unknown.
    """

    slope: Estimate
    levels: Array
    resolved: float
    tests: PathTests
    remark: Reason = Reason()
    share: Estimate = UNKNOWN

    @property
    def has_few_levels(self) -> bool:
        """Whether there are too few levels for a slope."""
        return len(self.levels) < FEWEST


def mean_order(evidence: Evidence, means: Means, claim: Claim | None) -> MeanOrder:
    """Return the order of one observable's mean differences, with the tests of a claim.

    Parameters
    ----------
    evidence : Evidence
    means : Means
        Of one observable, on each level.
    claim : Claim or None
        Claim that covers the observable.
    """
    sound, _ = sound_levels_of(evidence)
    levels = sound[sound < means.errors][-FITTED:]
    if len(levels) < FEWEST:
        few = Reason(TOO_FEW, numbers={"levels": len(levels), "fewest": FEWEST})
        return MeanOrder(UNKNOWN, levels, 0.0, PathTests.none(few), few)
    if _without_error(evidence, means, levels):
        exact = Reason(ROUNDING, numbers={"levels": len(levels)})
        return MeanOrder(UNKNOWN, levels, 0.0, PathTests.none(exact), exact)
    slope = means.slope(levels)
    resolved = means.least_signal(levels)
    if claim is None or not isinstance(claim.value, Order):
        return MeanOrder(slope, levels, resolved, PathTests.none(""))
    off = _off_limit(evidence, means)
    limit, blind = _limit(evidence, means, claim.value.least, off), _blind(evidence, means, levels, off)
    if resolved >= RESOLVED and not means.one_signed(levels):
        suspected = min(limit.suspected, shrinks(means, levels))
        tests = limit._replace(verified=1.0, blind=blind, suspected=suspected, limit=limit.refuted, remedy=Reason())
        return MeanOrder(slope, levels, resolved, hold_back(tests, evidence, levels), CHANGES_SIGN)
    tests = _tests(evidence, means, claim, (slope, levels, resolved, limit))
    tests = tests._replace(blind=blind, suspected=min(tests.suspected, limit.suspected))
    share = means.lower_share(sound[sound < means.errors][-FITTED - 1 :], claim.value.least)
    return MeanOrder(slope, levels, resolved, hold_back(tests, evidence, levels), share=share)


def _without_error(evidence: Evidence, means: Means, levels: Array) -> bool:
    size = 1.0 + abs(means.mean(int(levels[-1])).value)
    bound = 64.0 * EPS * size * sqrt(evidence.settings.steps[-1])
    return all(abs(means.difference(level).value) <= bound for level in levels.tolist())


def _tests(
    evidence: Evidence, means: Means, claim: Claim, found: tuple[Estimate, Array, float, PathTests]
) -> PathTests:
    slope, levels, resolved, limit = found
    if resolved < RESOLVED:
        growth = (RESOLVED / resolved) ** 2 if resolved > 0.0 else np.inf
        text = "bias below sampling noise ({standard_errors:.1f} standard errors; {needed:g} needed)"
        unresolved = Reason(text, numbers={"standard_errors": resolved, "needed": RESOLVED})
        tests = PathTests(1.0, limit.refuted, limit.reason.then(unresolved), growth, shrinks(means, levels))
        remedy = limit.remedy or ask_to_resolve(resolved, RESOLVED, evidence.paths)
        return tests._replace(limit=limit.refuted, remedy=remedy)
    order, corrected = order_tests(claim, slope, evidence), _corrected_slope(means, levels)
    assert isinstance(claim.value, Order)
    refuted = max(order.refuted, corrected.p_below(claim.value.floor))
    rising = means.rise(levels).interval(evidence.settings.confidence)[0] > RISING
    if rising or is_coarse_mean(means, int(levels[-1])) or turns(means, levels):
        refuted = 1.0
    tests = PathTests(
        max(order.verified, limit.verified),
        min(1.0, 2.0 * min(refuted, limit.refuted)),
        limit.reason.then(order.reason),
        order.growth,
        suspected=unlike(claim.value, slope, corrected),
        limit=min(1.0, 2.0 * limit.refuted),
    )
    if limit.remedy:
        ordered, reached = tests._replace(verified=order.verified), slope.value >= claim.value.floor
        tests = ordered.without_truth(evidence.level, _truth(means), reached=reached)
    return with_sample(tests, evidence.paths, heavy=False)


def _truth(means: Means) -> str:
    return f"a Moment of {means.name} or a Pathwise truth"


def _blind(evidence: Evidence, means: Means, levels: Array, off: Off | None) -> float:
    """Return the factor by which the number of paths must grow to detect a large weak error.

    Large means a quarter of the observable's size.
    """
    forbidden, confidence = COARSE * means.size, evidence.settings.confidence
    if means.coupled:
        return means.difference(int(levels[-1])).growth_to_see(forbidden, confidence)
    error = means.change(levels) if off is None else off[0]
    return error.growth_to_see(forbidden, confidence)


def shrinks(means: Means, levels: Array) -> float:
    """Return the p-value of the hypothesis that the finest difference is not larger than every other one."""
    return max(grown.p_above(0.0) for grown in means.grown(levels))


def is_coarse_mean(means: Means, finest: int) -> bool:
    """Return whether the error is comparable with the expectation itself: steps are too coarse for an order."""
    return abs(means.difference(finest).value) > COARSE * abs(means.mean(len(means.h) - 1).value)


def turns(means: Means, levels: Array) -> bool:
    """Return whether differences significantly grow with refinement up to some level and fall from there on.

    A slope across the largest of them is not an order.
    """
    top = int(np.argmax([abs(means.difference(level).value) for level in levels]))
    if top in (0, len(levels) - 1):
        return False
    grown, fallen = means.grown(levels[: top + 1])[0], means.grown(levels[top:])[0]
    return max(grown.p_above(0.0), fallen.p_below(0.0)) <= SUSPECT


def _corrected_slope(means: Means, levels: Array) -> Estimate:
    """Return the slope with a correction term; a slope on coarse steps refutes only if this one does, too."""
    further = np.arange(max(levels[0] - 1, 0), levels[-1] + 1)
    if len(further) <= FEWEST:
        return Estimate(float("nan"), float("nan"))
    return means.corrected_slope(further)


def _limit(evidence: Evidence, means: Means, order: float, off: Off | None) -> PathTests:
    """Compare the finest level with the known limit, which alone can confirm a limit."""
    if means.coupled:
        return PathTests(0.0, 1.0, Reason())
    if off is None:
        return PathTests.none("the exact mean is not known")._replace(remedy=ask_for_truth(_truth(means)))
    error, allowed = off[0], _left(means, order, off)
    wrong = _p_wrong(evidence, means, off, allowed)
    if means.heavy:
        # The limit may look wrong all the same.
        return PathTests.none("heavy tails: the mean of few paths confirms no limit")._replace(suspected=wrong)
    if grows(means):
        # The distance from the limit cannot be extrapolated.
        return PathTests.none("mean differences do not fall yet: take finer steps")._replace(suspected=wrong)
    # A mean that is off only for the claimed order tends to the limit, but more slowly.
    slowly = error.p_above(_left(means, SLOWEST, off)) > evidence.level
    text, kind = (SLOWER, Kind.PLAIN) if slowly else (Kind.WRONG_LIMIT, Kind.WRONG_LIMIT)
    figures = {"error": error.value, "left": allowed}
    reason = Reason(f"{text}: off by {{error:.2g}} at the finest step, {{left:.2g}} is allowed", kind, figures)
    return PathTests(0.0, wrong, reason if wrong <= evidence.level else Reason())


def _p_wrong(evidence: Evidence, means: Means, off: Off, allowed: float) -> float:
    """Return the p-value of the hypothesis that the finest mean is within the allowed distance of the limit."""
    p, truth = off[0].p_above(allowed), known_mean(evidence.problem, means.name)
    if truth is None or off != _off_expectation(evidence, means):
        return p
    is_low = means.mean(len(means.h) - 1).value < truth
    return correct_for_skewness(p, means.skewness if is_low else -means.skewness, float(means.counts.sum()))


def grows(means: Means) -> bool:
    """Return whether the last difference is significantly larger than for half of the slowest order."""
    before, last = (means.difference(level) for level in range(means.errors - 2, means.errors))
    return bool(abs(last.value) - RESOLVED * last.se > 2.0 ** (-0.5 * SLOWEST) * abs(before.value))


def _left(means: Means, order: float, off: Off) -> float:
    """Return the largest distance of the finest level from the known limit for errors of an order."""
    return SLACK * float(_last_difference(means, order) / (2.0**order - 1.0) + off[1])


def _last_difference(means: Means, order: float) -> float:
    """Return a bound of the last difference, also from coarser ones, because noise or a zero may make it small."""
    found = [means.difference(level) for level in range(means.errors)]
    shown = [abs(d.value) * (means.h[-2] / h) ** order for d, h in zip(found, means.h, strict=False)]
    return float(max(shown)) + RESOLVED * found[-1].se


def _off_limit(evidence: Evidence, means: Means) -> Off | None:
    """Return the distance of the finest level from the known limit, by the sharper of two ways, with its error.

    None if the exact solution is known on each path, and if the limit is unknown.
    """
    if means.coupled:
        return None
    known = [found for found in (_off_expectation(evidence, means), _off_reference(evidence, means)) if found]
    return min(known, key=lambda found: found[0].se + found[1], default=None)


def _off_expectation(evidence: Evidence, means: Means) -> Off | None:
    truth = known_mean(evidence.problem, means.name)
    if truth is None:
        return None
    last = means.mean(len(means.h) - 1)
    return Estimate(abs(last.value - truth), last.se), 0.0


def _off_reference(evidence: Evidence, means: Means) -> Off | None:
    """Return the distance from a reference on the same paths, whose common sampling error cancels."""
    found, pathwise = means.off_reference, evidence.problem.pathwise
    if found is None or pathwise is None:
        return None
    # Halving the step of a reference of order q removes all but 1/2^q of its error.
    return found[0], found[1] / (2.0**pathwise.order - 1.0)


class Weak(Measure):
    """Weak order of convergence for each observable; for the state if there is none."""

    name: ClassVar[str] = "weak"
    follows: ClassVar[str] = "law"
    resolved_by_steps: ClassVar[bool] = True
    step_tolerance: ClassVar[float] = TOLERANCE
    truths: ClassVar[frozenset[str]] = frozenset({"problem"})
    detail_columns: ClassVar[Mapping[str, str]] = {
        "moment_order": "weak order at T by moment equations",
        "slope": "slope of the mean differences; an order only if they are informative",
        "slope_low": "lower end of its interval",
        "slope_high": "upper end of its interval",
        "resolved": "smallest mean difference in standard errors",
        "informative": "whether the mean differences are large enough to estimate an order",
        **leading_columns("weak error"),
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "mean": "mean of the observable",
        "mean_std_error": "its standard error",
        "coupled": "whether the error is the difference from the exact solution rather than from the next level",
    }

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> MeanObserver:
        """Return the observer of one block."""
        return MeanObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return local weak defects, and errors of propagated moments."""
        return probe_weak(scheme, view, settings).merge(probe_bounds(scheme, view))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each observable, and its levels."""
        means, probed = means_of(evidence), weak_probe(evidence)
        findings = [_finding(evidence, found, probed) for found in means.values()]
        findings = _enough(findings or [_of_state(evidence, probed)])
        bounds = bound_findings(evidence, means)
        return Judgement((*findings, *bounds), (row for found in means.values() for row in _levels(found)))

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Return a finding for the state: the order of all test functions after one step."""
        covered = claim_for(scheme, view.traits, self.name, STATE)
        if covered.claim is None:
            return _of_named(scheme, view)
        return (member_finding(scheme, view, covered),) if isinstance(covered.claim.value, Order) else ()

    def judge_step(self, scheme: Scheme, problem: Problem, view: Any) -> Iterator[Finding]:
        """Yield a finding for the state and each observable with a claim, by the order of one step."""
        settings = Settings()
        evidence = Evidence(scheme, problem, view, settings, probe_weak(scheme, view, settings), Tally())
        for name in (STATE, *view.observables):
            covered = claim_for(scheme, view.traits, self.name, name)
            opinion, _ = judge_probe(evidence, covered.claim, name)
            if covered.claim is not None and opinion is not None:
                yield finding(covered, opinion, estimate=weak_probe(evidence).order)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Weak()]


def _of_named(scheme: Scheme, view: Any) -> Iterator[Finding]:
    """Yield open findings on claims that name observables, because random members test all smooth functions."""
    for claim in scheme.promises:
        if claim.measure == Weak.name and claim.when <= view.traits and isinstance(claim.value, Order):
            named = " and ".join(claim.quantities)
            reason = f"the claim is about the mean of {named} only, but members are tested on all smooth functions"
            yield finding(Coverage(named, claim), local_doubt(reason))


def _finding(evidence: Evidence, means: Means, probed: WeakProbe) -> Finding:
    covered = coverage(evidence, Weak.name, means.name)
    sampled = mean_order(evidence, means, covered.claim)
    opinion = _opinion(evidence, sampled, covered)
    left_out = sound_levels_of(evidence)[1] if sampled.has_few_levels else Reason()
    confidence = evidence.settings.confidence
    by_paths = covered.claim is not None and opinion.tier == SAMPLED and not opinion.reason.has(Kind.GUARD)
    low, high = sampled.slope.interval(confidence) if opinion.tier == 3 else (float("nan"), float("nan"))
    return finding(
        covered,
        opinion.plus(Reason() if opinion.reason.includes(sampled.remark) else sampled.remark, left_out),
        estimate=sampled.slope.value if opinion.tier == 3 else probed.order,
        low=low,
        high=high,
        resolution=weak_resolution(evidence, means, _off_limit(evidence, means), covered.claim),
        order_resolution=order_resolution(sampled.share, confidence) if by_paths else float("nan"),
        method=_method(opinion.tier, means),
        details={**probed.details, **_details(sampled, confidence), **constant_columns(evidence, means.name)},
    )


def _opinion(evidence: Evidence, sampled: MeanOrder, covered: Coverage) -> Opinion:
    if covered.claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, covered.gap)
    if (lost := _lost(evidence)) is not None:
        return lost
    return judge_claim(covered, lambda claim: _of_order(evidence, sampled, claim, covered.quantity))


def _of_order(evidence: Evidence, sampled: MeanOrder, claim: Claim, observable: str) -> Opinion:
    local, confirmed = judge_probe(evidence, claim, observable)
    # If the order at T is known without sampling, paths need not resolve it.
    tests = sampled.tests._replace(blind=1.0) if confirmed else sampled.tests
    if local is not None and local.verdict is Verdict.VERIFIED:
        # A difference that is small by accident spoils a slope; only finer levels can show this.
        tests = tests._replace(refuted=tests.limit, suspected=tests.against)
    elif isinstance(claim.value, Order):
        tests = resolve_order(tests, claim.value, sampled.share, evidence)
    opinion = guard(local, tests, evidence)
    if sampled.has_few_levels and opinion.verdict is Verdict.VERIFIED:
        return Opinion(Verdict.INCONCLUSIVE, opinion.reason.then(sampled.remark, ", but "))
    return opinion


def _lost(evidence: Evidence) -> Opinion | None:
    """Return the opinion that paths are not finite at the finest level; None if all are finite."""
    lost = float(evidence.health.sums["lost"][-1])
    opinion = diverged(Opinion(Verdict.INCONCLUSIVE, Reason(LOST, numbers={"lost": lost})), lost)
    return opinion if lost > 0 else None


def _of_state(evidence: Evidence, probed: WeakProbe) -> Finding:
    """Return the finding on a problem without observables: by probing, without a guard."""
    covered = coverage(evidence, Weak.name, STATE)
    opinion, _ = judge_probe(evidence, covered.claim, STATE)
    if covered.claim is None or opinion is None or opinion.verdict is Verdict.INCONCLUSIVE:
        open_ = leave_open(covered, "the problem has no observables, and one step does not decide")
        return finding(covered, open_, details=probed.details)
    method = METHODS[opinion.tier]
    sound, remarks = sound_levels_of(evidence)
    if (lost := _lost(evidence)) is not None:
        opinion = lost
    elif len(sound) < FEWEST and opinion.verdict is Verdict.VERIFIED:
        opinion = Opinion(Verdict.INCONCLUSIVE, opinion.reason.then(remarks, ", but "))
    return finding(covered, opinion, estimate=probed.order, method=method, details=probed.details)


def _method(tier: int, means: Means) -> Method:
    pairs = "differences to the exact solution" if means.coupled else "successive differences"
    return METHODS[tier]._replace(guard=pairs) if tier in METHODS else Method(f"{pairs} along paths", 3)


def _enough(findings: list[Finding]) -> list[Finding]:
    """Return findings in which paths alone verify no claim unless there are three informative functionals."""
    sampled = [f for f in findings if f.tier == 3 and f.verdict is Verdict.VERIFIED]
    if len(sampled) >= FUNCTIONALS:
        return findings
    doubt = f"paths alone need {FUNCTIONALS} informative observables and there {'is' if len(sampled) == 1 else 'are'}"
    return [_held(f, f"{doubt} {len(sampled)}") if f in sampled else f for f in findings]


def _held(found: Finding, doubt: str) -> Finding:
    """Return the finding as inconclusive, with the doubt after the reasons that support the claim."""
    return withhold(replace(found, reason=found.reason.then(doubt, ", but ")), "")


def _details(sampled: MeanOrder, confidence: float) -> dict[str, object]:
    low, high = sampled.slope.interval(confidence)
    return {
        "slope": sampled.slope.value,
        "slope_low": low,
        "slope_high": high,
        "resolved": sampled.resolved,
        "informative": not sampled.remark and sampled.resolved >= RESOLVED,
    }


def _levels(means: Means) -> Iterator[LevelFinding]:
    for level in range(means.errors):
        difference, mean = means.difference(level), means.mean(level)
        details = {"mean": mean.value, "mean_std_error": mean.se, "coupled": means.coupled}
        yield LevelFinding(means.name, level, difference.value, difference.se, details)
