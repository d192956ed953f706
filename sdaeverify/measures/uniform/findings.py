"""What becomes of a claim of uniform convergence: a component's findings on the grid and in continuous time."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Order, Word
from ...contracts.finding import Finding, Kind, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...numerics.statistics import slope_weights
from ...probe.local.consistency import Consistency, consistency_orders
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.fitted_levels import FEWEST, FITTED, at_levels
from ...verdicts.opinions import beside, decide, finding, local_doubt, local_opinion, no_fit
from ...verdicts.path_tests import PathTests, order_tests
from ..path_errors.order import (
    EXACT,
    RIGHT_LIMIT,
    STILL,
    Bias,
    Fit,
    calibrate,
    fit,
    is_exact,
    path_tests,
    rises,
    stands_still,
    usable_levels,
)
from ..path_errors.quantity import Quantity

# What paths say of convergence without rate: errors fall, towards the right limit.
#
# Convergence is about h tending to 0, and a run ends at a finest h. What it can show is that errors fall with h over
# the fitted levels, and that nothing yet points at another limit:
#
# verified
#     the slope of log2 E e_l against log2 h is above `FALLING`, and the contrast between errors and successive
#     differences shows no plateau: two tests, both have to reject;
# refuted
#     errors grow as h is halved, or they fall less than half as fast as successive differences do: they level off.
#     The contrast alone refutes nothing here. It is negative, too, while errors a h + b h^2 bend, which without a
#     claimed order cannot be told from a plateau; half the speed is beyond such a bend.
#
# A limit that is nearer than about a third of the last error leaves no trace in either. So a scheme whose one-step
# map can be probed has to be consistent as well. Where steps were truncated the scheme is not yet what it tends to:
# such levels may show that errors fall, and refute nothing.


CONVERGES = Word("converges")
# A slower fall cannot be told from none over a few halvings.
FALLING = 0.1
LEVELLED = 0.5
SHOWS = "a limit nearer than a third of that would not show, nor what happens below it"
MEASURE = "uniform"
NOISE, DRIFT = 0.5, 1.0
# The order of an interpolant of a path that is as rough as Brownian motion, but for a logarithm.
ROUGH = 0.5
# Local orders are known to a few hundredths; no slower convergence is told from none.
SLOWEST = 0.05


class Grid(NamedTuple):
    """What is known of a component on the grid.

    Attributes
    ----------
    tests : PathTests
        Of its claim.
    limit : float
        p-value of the hypothesis that it tends to a wrong limit; 1 where that cannot be told.
    """

    tests: PathTests
    limit: float


def levels_for(evidence: Evidence, quantity: Quantity, claim: Claim | None) -> tuple[Array, Reason]:
    """Return the levels that can be fitted, and what is to be said of levels.

    A theorem on convergence is about the scheme with its truncation: truncated levels count, and are named.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    claim : Claim or None
        Of convergence or of an order.
    """
    if claim is None or claim.value != CONVERGES:
        return usable_levels(evidence, quantity)
    sums = evidence.health.sums
    truncated = sums["truncated"] > 0
    untouched: Mapping[str, Array] = {**sums, "truncated": np.zeros_like(sums["truncated"])}
    usable, left_out = usable_levels(replace(evidence, health=replace(evidence.health, sums=untouched)), quantity)
    named = at_levels("truncated steps", truncated) if truncated.any() else ""
    return usable, left_out.then(named)


def grid_tests(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim) -> PathTests:
    """Return what errors on the grid say of a claim: of convergence or of an order.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors on the grid, one for each level.
    fitted : Fit
        Their slope.
    claim : Claim
        Of convergence or of an order.
    """
    if claim.value != CONVERGES:
        return path_tests(evidence, quantity, fitted, claim)
    if not np.isfinite(fitted.bias.bound):
        return PathTests.none(f"no finite interval: {fitted.bias.reference} is too coarse or not finite")
    tests = fall_tests(evidence, quantity, fitted)
    if fitted.bias.knows_limit:
        tests = _with_plateau(evidence, quantity, fitted, tests)
    else:
        tests = _towards_its_own(evidence, tests)
    return calibrate(tests, quantity, fitted.levels)


def limit_test(quantity: Quantity, fitted: Fit) -> float:
    """Return the p-value of the hypothesis that errors leave successive differences behind: of a wrong limit."""
    if not fitted.bias.knows_limit:
        return 1.0
    return quantity.contrast(fitted.levels).p_above(RIGHT_LIMIT, fitted.bias.bound)


def continuous_tests(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim, grid: Grid) -> PathTests:
    """Return what errors in continuous time say of a claim.

    Convergence needs no bound of the bias. An error is at most the distance from the finest paths and the error of
    these: the first has to fall here, the second on the grid, where the limit is told as well.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Distances from the finest paths between grid times, one for each level.
    fitted : Fit
        Their slope.
    claim : Claim
        Of convergence or of an order.
    grid : Grid
        What the errors at grid times came to.
    """
    if claim.value == CONVERGES:
        unbiased = fitted._replace(bias=fitted.bias._replace(bound=0.0))
        grown = fall_tests(evidence, quantity, fitted).refuted
        tests = fall_tests(evidence, quantity, unbiased)._replace(
            refuted=min(1.0, 2.0 * min(grown, grid.tests.refuted))
        )
        needed, why = max(grid.limit, grid.tests.verified), "that the errors on the grid fall to 0"
    elif not np.isfinite(fitted.bias.bound):
        return PathTests.none(f"no finite interval: {fitted.bias.reference}")
    else:
        tests = order_tests(claim, fitted.slope, evidence, fitted.bias.bound)
        needed, why = grid.limit, "the right limit"
    if needed > evidence.level:
        growth = max(tests.growth, grid.tests.growth)
        doubt = Reason("{why} is not shown (p = {p:.2g})", numbers={"why": why, "p": needed})
        tests = tests._replace(reason=doubt.then(tests.reason), growth=growth)
    return calibrate(tests._replace(verified=max(tests.verified, needed)), quantity, fitted.levels)


def fall_tests(evidence: Evidence, quantity: Quantity, fitted: Fit) -> PathTests:
    """Return the tests of a fall of errors, and of their growth.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    fitted : Fit
        Their slope, and the bias of what they are measured against.
    """
    slope, bias, last = fitted.slope, fitted.bias.bound, fitted.levels[-1]
    low, high = slope.interval(evidence.settings.confidence, bias)
    if not np.isfinite([low, high]).all():
        return PathTests.none("no finite interval")
    size = f"{quantity.means()[last]:.2g} at h = {quantity.h[last]:.3g}"
    text = "errors go with h^{order:.2f}, at least {low:.2f} and at most {high:.2f}, to {size}"
    figures = {"order": slope.value, "low": low, "high": high, "size": size}
    reason = Reason(text, Kind.ORDER, figures).then(SHOWS)
    growth = slope.growth_to_decide(FALLING, evidence.level, bias)
    grown = slope.p_below(0.0, bias)
    if not _may_refute(evidence, fitted) or rises(evidence, quantity, fitted):
        grown = 1.0
    return PathTests(slope.p_above(FALLING, bias), grown, reason, growth)


def finest_as_reference(quantity: Quantity, levels: Array, finest_error: float) -> Bias:
    """Return how far errors of the finest level, taken for the truth, can tilt a slope.

    With rho_l = E e / E c_l, e the error of the finest level, the true mean is within a factor 1 -+ rho_l of E c_l,
    by the triangle inequality. Its logarithm moves by at most -log2(1 - rho_l); the slope by sum_l |w_l| times that.

    Parameters
    ----------
    quantity : Quantity
        In continuous time.
    levels : ndarray of int
        Levels of the fit.
    finest_error : float
        E e, as far as it is known: on the coarsest grid.
    """
    weights = slope_weights(np.log2(quantity.h[levels]))
    ratio = finest_error / quantity.means()[levels]
    bound = float(np.abs(weights) @ -np.log2(1.0 - ratio)) if (ratio < 1.0).all() else np.inf
    share = f"{finest_error / quantity.means()[levels[-1]]:.0%}"
    return Bias(bound, f"the scheme's finest paths, off by {share} of the least error", True)


def _with_plateau(evidence: Evidence, quantity: Quantity, fitted: Fit, tests: PathTests) -> PathTests:
    bias, confidence = fitted.bias.bound, evidence.settings.confidence
    contrast, right = quantity.contrast(fitted.levels), limit_test(quantity, fitted)
    levelled = quantity.contrast(fitted.levels, LEVELLED).p_below(0.0, bias) if _may_refute(evidence, fitted) else 1.0
    reason, growth = tests.reason, tests.growth
    if levelled <= 0.5 * evidence.level:
        text = f"{Kind.WRONG_LIMIT}: errors level off, falling less than half as fast as successive differences"
        reason = Reason(text, Kind.WRONG_LIMIT).then(reason)
    elif tests.verified <= evidence.level < right:
        low = contrast.interval(confidence, bias)[0]
        reason = Reason(f"contrast at least {low:.3f}, of a right limit above {RIGHT_LIMIT}").then(reason)
        growth = max(growth, contrast.growth_to_decide(RIGHT_LIMIT, evidence.level, bias))
    return PathTests(max(tests.verified, right), min(1.0, 2.0 * min(tests.refuted, levelled)), reason, growth)


def _towards_its_own(evidence: Evidence, tests: PathTests) -> PathTests:
    growth = np.inf if tests.verified <= evidence.level else tests.growth
    return tests._replace(
        verified=1.0, growth=growth, reason=Reason("towards its own limit").then(tests.reason, ", ")
    )


def _may_refute(evidence: Evidence, fitted: Fit) -> bool:
    return not (evidence.health.sums["truncated"][fitted.levels] > 0).any()


class JudgedQuantity(NamedTuple):
    """The finding on a quantity, and the levels that its slope was fitted on."""

    quantity: Quantity
    finding: Finding
    fitted: frozenset[int] = frozenset()


class _Subject(NamedTuple):
    """A quantity, what is claimed of it, and what one step says."""

    evidence: Evidence
    quantity: Quantity
    covered: Coverage
    local: Opinion | None


def judge_pair(
    evidence: Evidence, grid: Quantity, between: Quantity, local: Opinion | None
) -> tuple[JudgedQuantity, JudgedQuantity]:
    """Judge a component on the grid, and in continuous time with what the grid says of its limit.

    Parameters
    ----------
    evidence : Evidence
    grid, between : Quantity
    local : Opinion or None
        Whether one step follows the equation; None where that cannot be told.

    Returns
    -------
    JudgedQuantity
        On the grid.
    JudgedQuantity
        In continuous time.
    """
    covered = coverage(evidence, MEASURE, grid.name), _coverage_in_time(evidence, between.name)
    first, second = (_Subject(evidence, q, c, local) for q, c in zip((grid, between), covered, strict=True))
    on_grid, known = _on_grid(first)
    return on_grid, _in_continuous_time(second, known, float(grid.means()[-1]))


def _coverage_in_time(evidence: Evidence, quantity: str) -> Coverage:
    """Return the claim about a quantity in continuous time: no order above 1/2 that does not name it.

    No scheme knows a path between two grid points, where an interpolant of a rough component has the order 1/2:
    whoever claims more of all quantities means those at grid points.
    """
    covered = coverage(evidence, MEASURE, quantity)
    claim = covered.claim
    if claim is None or claim.quantities or not (isinstance(claim.value, Order) and claim.value.least > ROUGH):
        return covered
    text = f"an order above {ROUGH} that names no quantities is claimed at grid points"
    return Coverage(quantity, None, Reason(text, Kind.NO_CLAIM))


def _on_grid(subject: _Subject) -> tuple[JudgedQuantity, Grid]:
    evidence, quantity, claim = subject.evidence, subject.quantity, subject.covered.claim
    if is_exact(evidence, quantity):
        return _exact(subject)
    usable, remarks = levels_for(evidence, quantity, claim)
    if len(usable[-FITTED:]) < FEWEST:
        return _without_fit(subject, remarks), Grid(PathTests.none(remarks), 1.0)
    fitted = fit(evidence, quantity, usable, remarks)
    tests = grid_tests(evidence, quantity, fitted, claim) if claim else PathTests.none("")
    contrast = quantity.contrast(fitted.levels)
    low, high = contrast.interval(evidence.settings.confidence)
    details = {"contrast": contrast.value, "contrast_low": low, "contrast_high": high}
    return _of_slope(subject, fitted, tests, details), Grid(tests, limit_test(quantity, fitted))


def _in_continuous_time(subject: _Subject, grid: Grid, finest_error: float) -> JudgedQuantity:
    evidence, quantity, claim = subject.evidence, subject.quantity, subject.covered.claim
    usable, remarks = levels_for(evidence, quantity, claim)
    levels = usable[-FITTED:]
    if len(levels) < FEWEST:
        return _without_fit(subject, remarks or Reason("there are too few"))
    bias = finest_as_reference(quantity, levels, finest_error)
    fitted = Fit(usable, levels, remarks, quantity.slope(levels), bias)
    tests = continuous_tests(evidence, quantity, fitted, claim, grid) if claim else PathTests.none("")
    return _of_slope(subject, fitted, tests, {})


def _without_fit(subject: _Subject, remarks: Reason) -> JudgedQuantity:
    opinion = no_fit(subject.evidence, subject.covered, remarks)
    return JudgedQuantity(subject.quantity, finding(subject.covered, opinion, method=Method("paths")))


def _of_slope(subject: _Subject, fitted: Fit, tests: PathTests, details: Mapping[str, object]) -> JudgedQuantity:
    quantity, bias = subject.quantity, fitted.bias
    opinion = _opinion(subject, tests).plus(fitted.left_out)
    low, high = fitted.slope.interval(subject.evidence.settings.confidence, bias.bound)
    found = finding(
        subject.covered,
        opinion,
        estimate=fitted.slope.value,
        low=low,
        high=high,
        method=Method("local consistency", 1) if opinion.tier == 1 else Method("paths", 3, reference=bias.reference),
        details={
            "std_error": fitted.slope.se,
            "order_L2": quantity.slope_in(fitted.levels, 2).value,
            "order_L4": quantity.slope_in(fitted.levels, 3).value,
            "fitted_levels": len(fitted.levels),
            "bias_bound": bias.bound,
            **details,
        },
    )
    return JudgedQuantity(quantity, found, frozenset(fitted.levels.tolist()))


def _opinion(subject: _Subject, tests: PathTests) -> Opinion:
    """Return the verdict of the paths, unless a single step is wrong already."""
    local = subject.local
    if subject.covered.claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, subject.covered.gap)
    if local is not None and local.verdict is Verdict.REFUTED:
        return local
    return beside(local, decide(tests, subject.evidence))


def _exact(subject: _Subject) -> tuple[JudgedQuantity, Grid]:
    still = stands_still(subject.evidence, subject.quantity)
    opinion = Opinion(*((Verdict.INCONCLUSIVE, Reason(STILL)) if still else (Verdict.VERIFIED, Reason(EXACT))))
    if subject.covered.claim is None:
        opinion = Opinion(Verdict.OUT_OF_SCOPE, subject.covered.gap)
    # The limit is known to rounding.
    p_value = 1.0 if still else 0.0
    judged = JudgedQuantity(subject.quantity, finding(subject.covered, opinion, method=Method("paths", 3)))
    return judged, Grid(PathTests(p_value, 1.0, opinion.reason), p_value)


def judge_consistency(record: Consistency, component: int | None = None) -> Opinion:
    """Return whether one step follows the equation in a component, or in the full state.

    Parameters
    ----------
    record : Consistency
    component : int, optional
        Its index; the full state if left out.

    Returns
    -------
    Opinion
        Refuted if it does not so at most states.
    """
    noise, drift = consistency_orders(record, component)
    wrong = (noise < NOISE + SLOWEST) | (drift < DRIFT + SLOWEST)
    known = ~(np.isnan(noise) | np.isnan(drift))
    first, later = wrong.mean(axis=1)
    if min(first, later) > 0.5:
        figures = f"its defect is of order {noise.min():.2f}, in the mean {drift.min():.2f}"
        text = f"one step does not follow the equation at {first:.0%} of the states: {figures}"
        return local_opinion(Verdict.REFUTED, text, Kind.INCONSISTENT)
    if wrong.any():
        text = f"one step does not follow the equation at {first:.0%} of the states, later ones at {later:.0%}"
        return local_doubt(text, against=later > 0.0)
    if not known.all():
        return local_doubt("whether one step follows the equation is not known at all states")
    return local_opinion(Verdict.VERIFIED, "one step follows the equation")
