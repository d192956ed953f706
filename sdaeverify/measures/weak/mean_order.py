"""The order of weak errors from paths: a slope of log2 |mean difference|, its limit, and whether it tells anything.

Differences are paired: with the exact solution on the same path where it is known, between successive step sizes
elsewhere. The latter do not see a wrong limit, so that the finest level is compared with a known expectation.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.finding import Kind, Reason
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...forms.truths import Moment
from ...numerics.statistics import RISING, Estimate, corrected_slope_weights, slope_weights
from ..judge import COARSE, FEWEST, FITTED, RESOLVED, PathTests, hold_back, order_tests, sound_levels, with_sample
from ..means import Means

TOO_FEW = "fewer than three levels without failures"
# Errors a h^p + b h^(p+1) leave this much more than the last difference over 2^p - 1 at the finest level.
SLACK = 2.0


class MeanOrder(NamedTuple):
    """What the paths say of one observable.

    Attributes
    ----------
    slope : Estimate
    levels : ndarray of int
        Differences that are fitted.
    resolved : float
        Least ratio of a difference to its standard error.
    tests : PathTests
    remark : str
        Why the observable is not used; empty if it is.
    """

    slope: Estimate
    levels: Array
    resolved: float
    tests: PathTests
    remark: str = ""


def mean_order(evidence: Evidence, means: Means, claim: Claim | None) -> MeanOrder:
    """Return the order of one observable's mean differences, with the tests of a claim."""
    sound, _ = sound_levels(evidence.health.sums)
    levels = sound[sound < means.errors][-FITTED:]
    unknown = Estimate(float("nan"), float("nan"))
    if len(levels) < FEWEST:
        return MeanOrder(unknown, levels, 0.0, PathTests.none(TOO_FEW), TOO_FEW)
    if _without_error(evidence, means, levels):
        return MeanOrder(unknown, levels, 0.0, PathTests.none("no error beyond rounding"), "no error beyond rounding")
    slope = means.functional(levels, slope_weights(np.log2(means.h[levels])))
    resolved = means.resolved(levels)
    if claim is None or isinstance(claim.value, str):
        return MeanOrder(slope, levels, resolved, PathTests.none(""))
    limit, blind = _limit(evidence, means, claim.value), _blind(evidence, means, levels)
    if not means.one_signed(levels) and resolved >= RESOLVED:
        remark = "uninformative: its error changes sign between levels"
        tests = hold_back(limit._replace(verified=1.0, blind=blind), evidence, levels)
        return MeanOrder(slope, levels, resolved, tests, remark)
    tests = _tests(evidence, means, claim, (slope, levels, resolved, limit))
    tests = tests._replace(blind=blind, suspected=min(tests.suspected, limit.suspected))
    return MeanOrder(slope, levels, resolved, hold_back(tests, evidence, levels))


def _without_error(evidence: Evidence, means: Means, levels: Array) -> bool:
    size = 1.0 + abs(means.mean(int(levels[-1])).value)
    bound = 64.0 * np.finfo(float).eps * size * np.sqrt(evidence.settings.steps[-1])
    return all(abs(means.difference(int(level)).value) <= bound for level in levels)


def _tests(
    evidence: Evidence, means: Means, claim: Claim, found: tuple[Estimate, Array, float, PathTests]
) -> PathTests:
    slope, levels, resolved, limit = found
    if resolved < RESOLVED:
        growth = (RESOLVED / resolved) ** 2 if resolved > 0.0 else np.inf
        unresolved = Reason(
            "mean differences unresolved ({errors:.1f} standard errors)", numbers={"errors": resolved}
        )
        return PathTests(1.0, limit.refuted, limit.reason.then(unresolved), growth)
    order = order_tests(claim, slope, evidence)
    assert not isinstance(claim.value, str)
    refuted = max(order.refuted, _corrected_slope(means, levels).p_below(claim.value - claim.margin))
    if means.functional(levels[-3:], np.array([-1.0, 2.0, -1.0])).interval(evidence.settings.confidence)[0] > RISING:
        refuted = 1.0
    if _coarse(means, int(levels[-1])):
        refuted = 1.0
    reason, either = limit.reason.then(order.reason), min(1.0, 2.0 * min(refuted, limit.refuted))
    tests = PathTests(max(order.verified, limit.verified), either, reason, order.growth)
    return with_sample(tests, evidence.paths, heavy=False)


def _blind(evidence: Evidence, means: Means, levels: Array) -> float:
    """Return by which factor the paths must grow until they show an error of a quarter of what the observable is."""
    known, forbidden, confidence = _limit_error(evidence, means), COARSE * means.size, evidence.settings.confidence
    if means.coupled:
        return means.difference(int(levels[-1])).growth_to_see(forbidden, confidence)
    error = means.change(levels) if known is None else known[0]
    return error.growth_to_see(forbidden, confidence)


def _coarse(means: Means, finest: int) -> bool:
    """Tell whether the error is of the size of the expectation itself: no order shows on such steps."""
    return abs(means.difference(finest).value) > COARSE * abs(means.mean(len(means.h) - 1).value)


def _corrected_slope(means: Means, levels: Array) -> Estimate:
    """Return the slope with a correction term: one on coarse steps refutes only if this one does, too."""
    further = np.arange(max(levels[0] - 1, 0), levels[-1] + 1)
    if len(further) <= FEWEST:
        return Estimate(float("nan"), float("nan"))
    return means.functional(further, corrected_slope_weights(np.log2(means.h[further])))


def _limit(evidence: Evidence, means: Means, order: float) -> PathTests:
    """Compare the finest level with what is known of the limit: only that can confirm it."""
    if means.coupled:
        return PathTests(0.0, 1.0, Reason())
    left = SLACK * _last_difference(means, order) / (2.0**order - 1.0)
    known = _limit_error(evidence, means)
    if known is None:
        return PathTests.none("towards its own limit")
    error, allowed = known[0], left + SLACK * known[1]
    wrong = error.p_above(allowed)
    if means.heavy:
        # It may look wrong all the same.
        return PathTests.none("heavy tails: a mean of few paths confirms no limit")._replace(suspected=wrong)
    text = f"{Kind.WRONG_LIMIT}: off by {{error:.2g}}, where {{left:.2g}} is left"
    reason = Reason(text, Kind.WRONG_LIMIT, {"error": error.value, "left": allowed})
    return PathTests(0.0, wrong, reason if wrong <= evidence.level else Reason())


def _last_difference(means: Means, order: float) -> float:
    """Return how large the last difference can be: noise and accidental zeros may hide what coarser ones show."""
    found = [means.difference(level) for level in range(means.errors)]
    shown = [abs(d.value) * (means.h[-2] / h) ** order for d, h in zip(found, means.h, strict=False)]
    return float(max(shown)) + RESOLVED * found[-1].se


def _limit_error(evidence: Evidence, means: Means) -> tuple[Estimate, float] | None:
    """Return how far the finest level is from what is known, and how far that is off itself."""
    truth = next((t for t in evidence.problem.truths if isinstance(t, Moment) and t.observable == means.name), None)
    if truth is not None:
        last = means.mean(len(means.h) - 1)
        return Estimate(abs(last.value - truth.value(evidence.problem.horizon)), last.se), 0.0
    found, pathwise = means.off_reference(), evidence.problem.pathwise
    if found is None or pathwise is None:
        return None
    # Halving the step of a reference of order q takes away all but 1/2^q of its error.
    return found[0], found[1] / (2.0**pathwise.order - 1.0)
