"""The order of pathwise errors: a slope with its interval, and its tests against a claim.

y_l = (1/p) log2 mean e_l^p against log2 h_l, with p = 1 for the verdict, and 1/2 and 2 in addition; the slope on the
finest four levels with a delete-a-group jackknife interval, widened by a bound of the slope's bias from the error of
the reference.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Order
from ...contracts.finding import Kind, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...forms.truths import Pathwise
from ...numerics.statistics import RISING, Estimate, slope_weights
from ...simulate.reference import OWN_REFERENCE
from ...verdicts.fitted_levels import FEWEST, FITTED, at_levels, sound_levels
from ...verdicts.path_tests import COARSE, SUSPECT, PathTests, hold_back, order_tests, resolve_order, with_sample
from .quantity import Quantity, quantities_of


class Bias(NamedTuple):
    """A bound of the slope's bias.

    Attributes
    ----------
    bound : float
        In units of order, to be added to an interval on either side; infinite if there is no bound.
    reference : str
        Name of the reference.
    knows_limit : bool
        Whether the reference is independent of the scheme, so that a wrong limit would be detected.
    """

    bound: float
    reference: str
    knows_limit: bool

    @property
    def above(self) -> float:
        """Upper bound of the true slope minus its estimate; 0 if the scheme is its own reference."""
        return self.bound if self.knows_limit else 0.0


def reference_bias(truth: Pathwise | None, quantity: Quantity, levels: Array, confidence: float) -> Bias:
    """Return a bound for the bias of the slope on some levels.

    The error of a truth of strong order q falls by 2^q (and its effect on the slope by at least as much) as its
    resolution doubles. So if the slope changes by D between half and full resolution, its bias at full resolution
    is at most |D|/(2^q - 1); D is measured on the same paths, and the far end of its interval is used. A scheme
    that is its own reference shifts y_l by at most log2(1 - r_l^p), r_l = h_ref/h_l, which is the shift of coherent
    errors; that of independent ones, log2(1 - r_l^(2 p))/2, is smaller and changes less from level to level.

    A scheme whose step equals the truth's, or nearly so, has almost no error at half resolution, and D is
    meaningless. Then the truth moves by little more than the scheme's error as its resolution doubles, which bounds
    the truth's error.

    Parameters
    ----------
    truth : Pathwise or None
    quantity : Quantity
    levels : ndarray of int
        Levels of the fit.
    confidence : float
        Of the interval of D.

    Returns
    -------
    Bias
    """
    if truth is None:
        return Bias(_own_bound(quantity, levels), f"own reference {OWN_REFERENCE} levels finer", False)
    if truth.exact:
        return Bias(0.0, "exact solution", True)
    bound = _shift_bound(truth, quantity, levels, slope_weights(np.log2(quantity.h[levels])), confidence)
    return Bias(bound, f"reference of order {truth.order} one level finer", True)


def _shift_bound(truth: Pathwise, quantity: Quantity, levels: Array, weights: Array, confidence: float) -> float:
    """Return a bound for the effect of the error of a truth on sum_l w_l y_l; see `reference_bias`."""
    change, part = max(map(abs, quantity.blur(levels, weights).interval(confidence))), 1.0 / (2.0**truth.order - 1.0)
    # Without any error at half resolution, neither the sum nor D is defined.
    return float(np.fmin(change * part, _near_bound(quantity, levels, weights, part)))


def _near_bound(quantity: Quantity, levels: Array, weights: Array, part: float) -> float:
    """Return a bound for a scheme that is near the truth at half its resolution; infinite if it is not.

    The truth moves by at most the sum of its distances from the scheme at half and at full resolution, and its
    error at full resolution is a fraction of that.
    """
    assert quantity.blurred is not None
    errors, finest = quantity.means()[levels], levels[-1]
    apart = float(quantity.blurred[:, finest].sum()) / quantity.paths + errors[-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Infinite if the truth's error may be as large as the scheme's.
        shifts = -np.log2(np.maximum(1.0 - part * apart / errors, 0.0))
        bound = float(np.abs(weights) @ shifts)
    return bound if np.isfinite(bound) else np.inf


def _own_bound(quantity: Quantity, levels: Array) -> float:
    h = quantity.h[levels]
    weights = slope_weights(np.log2(h))
    ratio = quantity.h[-1] / 2**OWN_REFERENCE / h
    order = max(quantity.slope(levels).value, 0.5)
    return float(abs(weights @ np.log2(1.0 - ratio**order)))


# A wrong limit shows as errors that stop falling while successive differences continue to fall.
# Chosen.
WRONG_LIMIT, RIGHT_LIMIT = -0.05, -0.15
NOT_CONFIRMED = f"{Kind.LIMIT}: errors may level off, p = {{p:.2g}} exceeds the level of the run"
EXACT = "exact to round-off at all {levels} step sizes"
# A scheme that does not move is exact on a solution that does not move.
STILL = "the solution changes by {moved:.1g} only, which is round-off: there is no error to measure"
# If errors of order 1/2 fall, halving a step changes a solution by at least 2^(1/2) - 1 times the finer error.
# Theorem: by the triangle inequality, E|x_l - x_(l+1)| >= E e_l - E e_(l+1); it is E e_(l+1) for orthogonal errors.
FALLING = 2.0**0.5 - 1.0


class Fit(NamedTuple):
    """A slope of errors along paths, fitted to the finest usable levels.

    Attributes
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    usable, levels : ndarray of int
        Usable levels, and the finest of them, to which the slope is fitted.
    left_out : Reason
        Why other levels are not usable.
    slope : Estimate
    bias : Bias
    """

    evidence: Evidence
    quantity: Quantity
    usable: Array
    levels: Array
    left_out: Reason
    slope: Estimate
    bias: Bias

    @property
    def interval(self) -> tuple[float, float]:
        """The interval of the slope, widened by its bias."""
        return self.slope.interval(self.evidence.settings.confidence, self.bias.bound)

    @property
    def rises(self) -> bool:
        """Whether the local order still rises with refinement, so that a low order may be due to coarse steps."""
        rise = self.quantity.rise(self.levels)
        return rise.interval(self.evidence.settings.confidence)[0] > RISING

    @property
    def p_wrong_limit(self) -> float:
        """p-value of the hypothesis of a wrong limit: errors stop falling while successive differences continue."""
        if not self.bias.knows_limit:
            return 1.0
        return self.quantity.contrast(self.levels).p_above(RIGHT_LIMIT, self.bias.bound)

    def calibrate(self, tests: PathTests) -> PathTests:
        """Return the tests, weakened if the sample is too small for its tails at the ends of the fit."""
        heavy = self.quantity.tail(self.levels[0]).heavy or self.quantity.tail(self.levels[-1]).heavy
        return with_sample(tests, self.quantity.paths, heavy=heavy)


def judge_exact(evidence: Evidence, quantity: Quantity, *, confirmed: bool = False) -> Opinion | None:
    """Return the opinion on any claim if all errors are rounding; None if there are larger ones.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    confirmed : bool, optional
        Whether one step is exact as well: the scheme's own finest steps are then used as the exact solution.
    """
    if not _is_exact(evidence, quantity, confirmed=confirmed):
        return None
    still = quantity.moved < 1e3 * 64.0 * quantity.rounding(np.array(evidence.settings.steps[-1]))
    if still:
        return Opinion(Verdict.INCONCLUSIVE, Reason(STILL, numbers={"moved": quantity.moved}))
    return Opinion(Verdict.VERIFIED, Reason(EXACT, numbers={"levels": len(quantity.h)}))


def _is_exact(evidence: Evidence, quantity: Quantity, *, confirmed: bool) -> bool:
    """Return whether errors relative to a truth are rounding at every level, and no step failed."""
    # A scheme that is its own reference may not move at all and agree with itself; one step detects that.
    health, rounding = evidence.health.sums, quantity.rounding(np.array(evidence.settings.steps))
    if (evidence.problem.pathwise is None and not confirmed) or health["failed"].any() or health["truncated"].any():
        return False
    return bool(np.all(quantity.means() <= 64.0 * rounding))


def usable_levels(evidence: Evidence, quantity: Quantity, *, truncated: bool = False) -> tuple[Array, Reason]:
    """Return the levels to which a slope can be fitted, and why others are omitted.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    truncated : bool, optional
        Whether levels with truncated steps are usable; they are mentioned in the reason.
    """
    health: Mapping[str, Array] = evidence.health.sums
    named = at_levels("truncated steps", health["truncated"] > 0) if truncated and health["truncated"].any() else ""
    if truncated:
        health = {**health, "truncated": np.zeros_like(health["truncated"])}
    sound, remarks = sound_levels(health)
    known = quantity.means()
    # Measured rounding stays below 2 eps sqrt(N) of the state's size; 30 times that does not affect the fit.
    rounding = known <= 60.0 * quantity.rounding(np.array(evidence.settings.steps[: len(known)]))
    if rounding.any():
        remarks = remarks.then(at_levels("round-off", rounding))
    # Slopes are not fitted across the fastest time, where errors change from one power law to another for any scheme.
    stiff = quantity.h > evidence.problem.fastest_time
    if stiff.any():
        remarks = remarks.then(at_levels("steps longer than the fastest time", stiff))
    sound = sound[sound < len(known)]
    return sound[~(rounding | stiff[: len(known)])[sound]], remarks.then(named)


def fit(evidence: Evidence, quantity: Quantity, usable: Array, left_out: Reason, bias: Bias | None = None) -> Fit:
    """Fit the slope on the finest usable levels.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    usable : ndarray of int
        Usable levels, coarse to fine.
    left_out : Reason
        Why the others are not usable.
    bias : Bias, optional
        If omitted, that of the problem's truth, or of a scheme that is its own reference.
    """
    levels = usable[-FITTED:]
    if bias is None:
        bias = reference_bias(evidence.problem.pathwise, quantity, levels, evidence.settings.confidence)
    return Fit(evidence, quantity, usable, levels, left_out, quantity.slope(levels), bias)


class LowerShare(NamedTuple):
    """The share of the error at the finest step that belongs to a term of half an order less than the claimed one.

    Attributes
    ----------
    estimate : Estimate
    bias : float
        Bound of the effect of the reference's error on it.
    """

    estimate: Estimate
    bias: float


def lower_share(fitted: Fit, claimed: Order) -> LowerShare:
    """Return the share of a lower term on the levels of the fit and one coarser level."""
    quantity, levels, truth = fitted.quantity, fitted.usable[-FITTED - 1 :], fitted.evidence.problem.pathwise
    found, bias = quantity.lower_share(levels, claimed.least), 0.0
    if truth is not None and not truth.exact:
        weights = quantity.share_weights(levels)
        bias = _shift_bound(truth, quantity, levels, weights, fitted.evidence.settings.confidence)
    return LowerShare(found, bias)


def resolve_lower_order(tests: PathTests, fitted: Fit, claimed: Order) -> PathTests:
    """Return the tests of a claimed order that paths alone decide; see `resolve_order`.

    Parameters
    ----------
    tests : PathTests
        Of the claim, see `path_tests`.
    fitted : Fit
        The errors to which the tests belong.
    claimed : Order
    """
    share, bias = lower_share(fitted, claimed)
    return resolve_order(tests, claimed, share, fitted.evidence, bias)


def path_tests(fitted: Fit, claim: Claim) -> PathTests:
    """Return the tests of a claimed order by paths: those of the slope, and those of the limit."""
    evidence, quantity = fitted.evidence, fitted.quantity
    truth, bias = evidence.problem.pathwise, fitted.bias
    if not np.isfinite(bias.bound):
        return PathTests.none(f"no finite interval of the order: the {bias.reference} is too coarse or not finite")
    claimed = claim.value
    if truth is not None and isinstance(claimed, Order) and not truth.order >= claimed.least + 0.5:
        return PathTests.none(f"to decide, the {bias.reference} needs an order of at least {claimed.least + 0.5:g}")
    tests = order_tests(claim, fitted.slope, evidence, bias.bound)
    low = tests.refuted <= SUSPECT and isinstance(claimed, Order)
    if bias.knows_limit:
        early = is_above(fitted, claim) or seems_early(quantity, fitted.levels, bias.bound)
        tests = with_limit(tests, fitted, early=early)
    else:
        reason = tests.reason.then("relative to the scheme's own limit because no exact solution is known", ", but ")
        tests = tests._replace(reason=reason)
        reached = isinstance(claimed, Order) and fitted.slope.value >= claimed.floor
        tests = tests.without_truth(evidence.level, "a Pathwise truth", reached=reached)
    if low and fitted.rises:
        # Errors on steps that are too coarse look like those of a wrong limit, too.
        tests = tests.held("the order still rises: take finer steps")
    coarse, growth = "", np.inf
    if tests.refuted <= SUSPECT:
        coarse = why_coarse(evidence, int(fitted.levels[-1]))
        if not coarse and (coarse := why_on_its_way(quantity, fitted.levels, claim)):
            growth = quantity.rise(fitted.levels).growth_to_decide(RISING, evidence.level)
    return hold_back(fitted.calibrate(tests), evidence, fitted.levels, coarse, growth)


def why_coarse(evidence: Evidence, finest: int) -> str:
    """Return a text on a component that the finest steps do not resolve, with its error; empty if there is none.

    Its error is a large part of the solution's motion, and halving the step still changes it by as much as if errors
    of order 1/2 or more fell, so they have not begun to fall. Other components, which it drives, do not show their
    orders then. The same holds if a scheme keeps its solution far below the true one, and approaches it faster with
    each halving. At a wrong limit errors are large and flat as well, but steps change it less and less.
    """
    for each in quantities_of(evidence):
        changes = each.difference[:, max(finest - 2, 0) : finest].sum(axis=0) / each.paths
        error, grows = each.means()[finest], each.local_orders[finest - 1].p_below(0.0) <= SUSPECT
        rising = changes[-1] > changes[0] and not grows
        if error > COARSE * each.motion and (changes[-1] > FALLING * error or rising):
            off = f"the error of {each.name} is {error / each.motion:.0%} of the solution's displacement"
            halved = "still changes as h is halved: take finer steps"
            return f"{off} at h = {each.h[finest]:.3g} and {halved}"
    return ""


def why_on_its_way(quantity: Quantity, levels: Array, claim: Claim) -> str:
    """Return a text that the local order, extrapolated by its last rise, reaches the claim; empty if it does not.

    Parameters
    ----------
    quantity : Quantity
    levels : ndarray of int
        Levels of the fit.
    claim : Claim
    """
    rise, ahead = quantity.rise(levels).value, quantity.ahead(levels).value
    if not (isinstance(claim.value, Order) and rise > RISING and ahead >= claim.value.floor):
        return ""
    return f"the order still rises, to {ahead:.2f} at the next step size: take finer steps"


def asymptotic_order(fitted: Fit) -> tuple[float, float]:
    """Return the asymptotic order with its half width: y = a + p x + c h on all usable levels except the coarsest.

    The interval includes the change by the coarsest level; its half width is at least 0.05.
    """
    quantity, usable, confidence = fitted.quantity, fitted.usable, fitted.evidence.settings.confidence
    if len(usable) <= FITTED:
        return float("nan"), float("nan")
    order = quantity.corrected_slope(usable[1:])
    gap = abs(order.value - quantity.corrected_slope(usable).value)
    return order.value, max(order.interval(confidence)[1] - order.value + gap, 0.05)


def is_above(fitted: Fit, claim: Claim) -> bool:
    """Return whether the interval of a slope is above the claimed order."""
    return isinstance(claim.value, Order) and fitted.interval[0] > claim.value.least


def seems_early(quantity: Quantity, levels: Array, bias: float) -> bool:
    """Return whether the finest errors fall like their differences, or significantly begin to do so.

    Other levels are too coarse then. Towards a wrong limit, errors level off further with each halving of the step.

    Parameters
    ----------
    quantity : Quantity
    levels : ndarray of int
        Levels of the fit.
    bias : float
        Bound of the bias of the slope.
    """
    if len(levels) <= FEWEST:
        return False
    here, rise = quantity.contrast(levels[-FEWEST:]), quantity.contrast_rise(levels)
    return here.p_below(WRONG_LIMIT, bias) > SUSPECT or rise.p_above(0.0) <= SUSPECT


def with_limit(tests: PathTests, fitted: Fit, *, early: bool) -> PathTests:
    """Return the tests of an order with those of its limit.

    Parameters
    ----------
    tests : PathTests
        Of the order.
    fitted : Fit
        Errors relative to a truth that is independent of the scheme.
    early : bool
        Whether the levels are too coarse to refute the limit: errors a h + b h^2 look like those of a wrong one if
        b h is large.
    """
    evidence, bias, contrast = fitted.evidence, fitted.bias.bound, fitted.quantity.contrast(fitted.levels)
    _, high = contrast.interval(evidence.settings.confidence, bias)
    wrong, right = contrast.p_below(WRONG_LIMIT, bias), fitted.p_wrong_limit
    if wrong <= 0.5 * evidence.level and early:
        return PathTests(1.0, 2.0 * wrong, tests.reason).held(_slower(Kind.LIMIT, high), "take finer steps")
    reason, growth = tests.reason, tests.growth
    if wrong <= 0.5 * evidence.level:
        reason = _slower(Kind.WRONG_LIMIT, high).then(reason)
    elif tests.verified <= evidence.level < right:
        reason = reason.then(Reason(NOT_CONFIRMED, Kind.LIMIT, {"p": right}))
        growth = max(growth, contrast.growth_to_decide(RIGHT_LIMIT, evidence.level, bias))
    limit = 1.0 if early else min(1.0, 2.0 * wrong)
    either = min(limit, 2.0 * tests.refuted)
    return PathTests(max(tests.verified, right), either, reason, growth, limit=limit)


def _slower(kind: Kind, contrast: float) -> Reason:
    # The contrast is the order of errors minus that of their differences, which do not depend on the limit.
    text = "{kind}: errors fall more slowly than their differences, by an order of at least {lag:.2f}"
    return Reason(text, kind, {"kind": kind, "lag": -contrast})
