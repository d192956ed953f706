"""The order of weak errors from paths: a slope of log2 |mean difference|, its limit, and whether it tells anything.

Differences are paired: with the exact solution on the same path where it is known, between successive step sizes
elsewhere. The latter do not see a wrong limit, so that the finest level is compared with a known expectation.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..measure import Evidence
from ..scheme import Claim
from ..statistics import Estimate, corrected_slope_weights, slope_weights
from ..truths import Moment
from ..verdicts import FEWEST, FITTED, Tests, order_tests, sound_levels, with_sample
from ._means import Means

# A mean difference counts as resolved from so many standard errors on; the sample is never ended by that.
RESOLVED = 3.0
# Errors a h^p + b h^(p+1) leave this much more than the last difference over 2^p - 1 at the finest level.
SLACK = 2.0
# Steps too coarse for the problem show as local orders that grow by more than this from one level to the next.
RISING = 0.05


class MeanOrder(NamedTuple):
    """What the paths say of one observable.

    Attributes
    ----------
    slope : Estimate
    levels : ndarray of int
        Differences that are fitted.
    resolved : float
        Least ratio of a difference to its standard error.
    tests : Tests
    remark : str
        Why the observable is not used; empty if it is.
    """

    slope: Estimate
    levels: Array
    resolved: float
    tests: Tests
    remark: str = ""


def mean_order(evidence: Evidence, means: Means, claim: Claim | None) -> MeanOrder:
    """Return the order of one observable's mean differences, with the tests of a claim."""
    sound, _ = sound_levels(evidence.health.sums)
    levels = sound[sound < means.errors][-FITTED:]
    unknown = Estimate(float("nan"), float("nan"))
    if len(levels) < FEWEST:
        return MeanOrder(unknown, levels, 0.0, Tests.none("too few levels without failures"), "too few levels")
    if _without_error(evidence, means, levels):
        return MeanOrder(unknown, levels, 0.0, Tests.none("no error beyond rounding"), "no error beyond rounding")
    slope = means.functional(levels, slope_weights(np.log2(means.h[levels])))
    resolved = means.resolved(levels)
    if claim is None or isinstance(claim.value, str):
        return MeanOrder(slope, levels, resolved, Tests.none(""))
    limit = _limit(evidence, means, claim.value)
    if not means.one_signed(levels) and resolved >= RESOLVED:
        remark = "uninformative: its error changes sign between levels"
        return MeanOrder(slope, levels, resolved, limit._replace(verified=1.0), remark)
    return MeanOrder(slope, levels, resolved, _tests(evidence, means, claim, (slope, levels, resolved, limit)))


def _without_error(evidence: Evidence, means: Means, levels: Array) -> bool:
    size = 1.0 + abs(means.mean(int(levels[-1])).value)
    bound = 64.0 * np.finfo(float).eps * size * np.sqrt(evidence.settings.steps[-1])
    return all(abs(means.difference(int(level)).value) <= bound for level in levels)


def _tests(evidence: Evidence, means: Means, claim: Claim, found: tuple[Estimate, Array, float, Tests]) -> Tests:
    slope, levels, resolved, limit = found
    if resolved < RESOLVED:
        growth = (RESOLVED / resolved) ** 2 if resolved > 0.0 else np.inf
        return Tests(1.0, limit.refuted, f"mean differences unresolved ({resolved:.1f} standard errors)", growth)
    order = order_tests(claim, slope, evidence)
    assert not isinstance(claim.value, str)
    refuted = max(order.refuted, _corrected(means, levels).p_below(claim.value - claim.margin))
    if means.functional(levels[-3:], np.array([-1.0, 2.0, -1.0])).interval(evidence.settings.confidence)[0] > RISING:
        refuted = 1.0
    reason = "; ".join(text for text in (order.reason, limit.reason) if text)
    tests = Tests(
        max(order.verified, limit.verified), min(1.0, 2.0 * min(refuted, limit.refuted)), reason, order.growth
    )
    return with_sample(tests, evidence.paths, heavy=False)


def _corrected(means: Means, levels: Array) -> Estimate:
    """Return the slope with a correction term: one on coarse steps refutes only if this one does, too."""
    further = np.arange(max(levels[0] - 1, 0), levels[-1] + 1)
    if len(further) <= FEWEST:
        return Estimate(float("nan"), float("nan"))
    return means.functional(further, corrected_slope_weights(np.log2(means.h[further])))


def _limit(evidence: Evidence, means: Means, order: float) -> Tests:
    """Compare the finest level with the known expectation: only a known one can confirm the limit."""
    if means.coupled:
        return Tests(0.0, 1.0, "")
    truth = next((t for t in evidence.problem.truths if isinstance(t, Moment) and t.observable == means.name), None)
    if truth is None:
        return Tests.none("towards its own limit")
    last = means.mean(len(means.h) - 1)
    error = Estimate(abs(last.value - truth.value(evidence.problem.horizon)), last.se)
    allowed = SLACK * abs(means.difference(len(means.h) - 2).value) / (2.0**order - 1.0)
    wrong = error.p_above(allowed)
    reason = f"wrong limit: off by {error.value:.2g}, where {allowed:.2g} is left" if wrong <= evidence.level else ""
    return Tests(0.0, wrong, reason)
