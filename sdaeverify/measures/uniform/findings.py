"""Judgement of claims of uniform convergence: a component's findings on the grid and in continuous time."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Order, Word
from ...contracts.finding import Kind, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...numerics.statistics import slope_weights
from ...probe.local.strong_order import NO_ORDER
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.fitted_levels import FEWEST, FITTED
from ...verdicts.opinions import beside, decide, finding, no_fit
from ...verdicts.path_tests import PathTests, order_tests
from ..path_errors.order import (
    RIGHT_LIMIT,
    Bias,
    Fit,
    fit,
    judge_exact,
    path_tests,
    resolve_lower_order,
    usable_levels,
)
from ..path_errors.quantity import JudgedQuantity, Quantity

# Tests of convergence without a rate: errors fall, towards the right limit.
#
# Convergence is about h tending to 0, and a run ends at a finest h. It can show that errors fall with h over
# the fitted levels, and that there is no evidence yet of another limit:
#
# verified
#     the slope of log2 E e_l against log2 h is above `NO_ORDER`, and the contrast between errors and successive
#     differences shows no plateau: two tests, both have to reject;
# refuted
#     errors grow as h is halved, or they fall less than half as fast as successive differences do: they level off.
#     The contrast alone does not refute here. It is also negative while errors a h + b h^2 bend, which without a
#     claimed order is indistinguishable from a plateau; half the speed is beyond such a bend.
#
# A limit that is nearer than about a third of the last error affects neither test. So a scheme whose one-step
# map can be probed has to be consistent as well. If steps were truncated the scheme is not yet in its asymptotic
# regime: such levels may show that errors fall, but do not refute.


CONVERGES = Word("converges")
# Errors that fall half as fast as successive differences are beyond the bend of a h^p + b h^(p+1).
# Theorem: elementary, with a, b > 0 its order is at least 0.68 (p = 1/2) or 0.83 (p = 1) of that of its differences.
LEVELLED = 0.5
MEASURE = "uniform"
# Theorem: the order, up to a logarithm, of an interpolant of a path as rough as Brownian motion (Levy's modulus).
ROUGH = 0.5


class Grid(NamedTuple):
    """Results for a component on the grid.

    Attributes
    ----------
    tests : PathTests
        Of its claim.
    limit : float
        p-value of the hypothesis that it tends to a wrong limit; 1 if that cannot be tested.
    """

    tests: PathTests
    limit: float


def grid_tests(fitted: Fit, claim: Claim) -> PathTests:
    """Return the tests of a claim, of convergence or of an order, by errors on the grid."""
    if claim.value != CONVERGES:
        tests = path_tests(fitted, claim)
        return resolve_lower_order(tests, fitted, claim.value) if isinstance(claim.value, Order) else tests
    if not np.isfinite(fitted.bias.bound):
        return PathTests.none(
            f"no finite interval of the order: the {fitted.bias.reference} is too coarse or not finite"
        )
    tests = fall_tests(fitted)
    limited = _with_plateau if fitted.bias.knows_limit else _towards_its_own
    return fitted.calibrate(limited(fitted, tests))


def continuous_tests(fitted: Fit, claim: Claim, grid: Grid) -> PathTests:
    """Return the tests of a claim by errors in continuous time.

    Convergence needs no bound of the bias. An error is at most the distance from the finest paths plus the error of
    these: the first has to fall here, the second on the grid, where the limit is tested as well.

    Parameters
    ----------
    fitted : Fit
        The slope of distances from the finest paths between grid times.
    claim : Claim
        Of convergence or of an order.
    grid : Grid
        The tests of errors at grid times.
    """
    evidence = fitted.evidence
    if claim.value == CONVERGES:
        unbiased = fitted._replace(bias=fitted.bias._replace(bound=0.0))
        grown = fall_tests(fitted).refuted
        tests = fall_tests(unbiased)._replace(refuted=min(1.0, 2.0 * min(grown, grid.tests.refuted)))
        needed, why = max(grid.limit, grid.tests.verified), "that errors on the grid tend to 0"
    elif not np.isfinite(fitted.bias.bound):
        return PathTests.none(f"no finite interval of the order: reference {fitted.bias.reference}")
    else:
        tests = order_tests(claim, fitted.slope, evidence, fitted.bias.bound)
        needed, why = grid.limit, "the right limit"
    if needed > evidence.level:
        growth = max(tests.growth, grid.tests.growth)
        doubt = Reason("not verified: {why} (p = {p:.2g})", numbers={"why": why, "p": needed})
        tests = tests._replace(reason=doubt.then(tests.reason), growth=growth, remedy=grid.tests.remedy)
    return fitted.calibrate(tests._replace(verified=max(tests.verified, needed)))


def fall_tests(fitted: Fit) -> PathTests:
    """Return the tests of a fall of errors, and of their growth."""
    evidence, quantity = fitted.evidence, fitted.quantity
    slope, bias, last = fitted.slope, fitted.bias.bound, fitted.levels[-1]
    low, high = fitted.interval
    if not np.isfinite([low, high]).all():
        return PathTests.none("the interval of the order along paths is not finite")
    error = quantity.means()[last]
    size = f"{error:.2g} at h = {quantity.h[last]:.3g}"
    text = "largest error ~ h^{order:.2f} [{low:.2f}, {high:.2f}], {size}; shows limit errors from {third:.1g}"
    figures = {"order": slope.value, "low": low, "high": high, "size": size, "third": error / 3.0}
    reason = Reason(text, Kind.ORDER, figures)
    growth = slope.growth_to_decide(NO_ORDER, evidence.level, bias)
    grown = slope.p_below(0.0, bias)
    if not _may_refute(fitted) or fitted.rises:
        grown = 1.0
    return PathTests(slope.p_above(NO_ORDER, bias), grown, reason, growth)


def finest_as_reference(quantity: Quantity, levels: Array, finest_error: float) -> Bias:
    """Return a bound of the bias of a slope if the finest level is used as the truth.

    With rho_l = E e / E c_l, e the error of the finest level, the true mean is within a factor 1 -+ rho_l of E c_l,
    by the triangle inequality. Its logarithm changes by at most -log2(1 - rho_l); the slope by sum_l |w_l| times
    that.

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
    return Bias(bound, f"the scheme's finest paths (off by {share} of the least error)", True)


def _with_plateau(fitted: Fit, tests: PathTests) -> PathTests:
    evidence, quantity = fitted.evidence, fitted.quantity
    bias = fitted.bias.bound
    contrast, right = quantity.contrast(fitted.levels), fitted.p_wrong_limit
    levelled = quantity.contrast(fitted.levels, LEVELLED).p_below(0.0, bias) if _may_refute(fitted) else 1.0
    reason, growth = tests.reason, tests.growth
    if levelled <= 0.5 * evidence.level:
        text = f"{Kind.WRONG_LIMIT}: errors fall less than half as fast as successive differences"
        reason = Reason(text, Kind.WRONG_LIMIT).then(reason)
    elif tests.verified <= evidence.level < right:
        text = f"{Kind.LIMIT}: errors may level off, p = {right:.2g} exceeds the level of the run"
        reason = Reason(text, Kind.LIMIT).then(reason)
        growth = max(growth, contrast.growth_to_decide(RIGHT_LIMIT, evidence.level, bias))
    return PathTests(max(tests.verified, right), min(1.0, 2.0 * min(tests.refuted, levelled)), reason, growth)


def _towards_its_own(fitted: Fit, tests: PathTests) -> PathTests:
    reason = Reason("relative to the scheme's own limit because no exact solution is known").then(tests.reason)
    reached = fitted.slope.value >= NO_ORDER
    return tests._replace(reason=reason).without_truth(fitted.evidence.level, "a Pathwise truth", reached=reached)


def _may_refute(fitted: Fit) -> bool:
    return not (fitted.evidence.health.sums["truncated"][fitted.levels] > 0).any()


class _Subject(NamedTuple):
    """A quantity, the claim that covers it, and the opinion of one step."""

    evidence: Evidence
    quantity: Quantity
    covered: Coverage
    local: Opinion | None


def judge_pair(
    evidence: Evidence, grid: Quantity, between: Quantity, local: Opinion | None
) -> tuple[JudgedQuantity, JudgedQuantity]:
    """Judge a component on the grid, and in continuous time with the test of the limit on the grid.

    Parameters
    ----------
    evidence : Evidence
    grid, between : Quantity
    local : Opinion or None
        Whether one step follows the equation; None if that is unknown.

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
    """Return the claim about a quantity in continuous time; a claim of an order above 1/2 has to name it.

    No scheme determines a path between two grid points, where an interpolant of a rough component has the order 1/2.
    So a claim of a higher order that names no quantity is about grid points.
    """
    covered = coverage(evidence, MEASURE, quantity)
    claim = covered.claim
    if claim is None or claim.quantities or not (isinstance(claim.value, Order) and claim.value.least > ROUGH):
        return covered
    text = f"no claim about {quantity}: orders above {ROUGH} are claimed at grid points only"
    return Coverage(quantity, None, Reason(text, Kind.NO_CLAIM))


def _levels_for(subject: _Subject) -> tuple[Array, Reason]:
    """Return the usable levels, and remarks on levels.

    A theorem on convergence is about the scheme with its truncation, so truncated levels are usable and are
    mentioned.
    """
    claim = subject.covered.claim
    truncated = claim is not None and claim.value == CONVERGES
    return usable_levels(subject.evidence, subject.quantity, truncated=truncated)


def _on_grid(subject: _Subject) -> tuple[JudgedQuantity, Grid]:
    evidence, quantity, claim = subject.evidence, subject.quantity, subject.covered.claim
    if (exact := judge_exact(evidence, quantity)) is not None:
        return _exact(subject, exact)
    usable, remarks = _levels_for(subject)
    if len(usable[-FITTED:]) < FEWEST:
        return _without_fit(subject, remarks), Grid(PathTests.none(remarks), 1.0)
    fitted = fit(evidence, quantity, usable, remarks)
    tests = grid_tests(fitted, claim) if claim else PathTests.none("")
    contrast = quantity.contrast(fitted.levels)
    low, high = contrast.interval(evidence.settings.confidence)
    details = {"contrast": contrast.value, "contrast_low": low, "contrast_high": high}
    return _of_slope(subject, fitted, tests, details), Grid(tests, fitted.p_wrong_limit)


def _in_continuous_time(subject: _Subject, grid: Grid, finest_error: float) -> JudgedQuantity:
    evidence, quantity, claim = subject.evidence, subject.quantity, subject.covered.claim
    usable, remarks = _levels_for(subject)
    levels = usable[-FITTED:]
    if len(levels) < FEWEST:
        return _without_fit(subject, remarks or Reason("fewer than 3 step sizes can be fitted"))
    bias = finest_as_reference(quantity, levels, finest_error)
    fitted = fit(evidence, quantity, usable, remarks, bias)
    tests = continuous_tests(fitted, claim, grid) if claim else PathTests.none("")
    return _of_slope(subject, fitted, tests, {})


def _without_fit(subject: _Subject, remarks: Reason) -> JudgedQuantity:
    opinion = no_fit(subject.evidence, subject.covered, remarks)
    return JudgedQuantity(subject.quantity, finding(subject.covered, opinion, method=Method("paths")))


def _of_slope(subject: _Subject, fitted: Fit, tests: PathTests, details: Mapping[str, object]) -> JudgedQuantity:
    quantity, bias = subject.quantity, fitted.bias
    opinion = _opinion(subject, tests).plus(fitted.left_out)
    low, high = fitted.interval
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
    """Return the verdict of the paths, unless a single step is refuted."""
    local = subject.local
    if subject.covered.claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, subject.covered.gap)
    if local is not None and local.verdict is Verdict.REFUTED:
        return local
    return beside(local, decide(tests, subject.evidence))


def _exact(subject: _Subject, opinion: Opinion) -> tuple[JudgedQuantity, Grid]:
    # The limit is known up to rounding.
    p_value = 0.0 if opinion.verdict is Verdict.VERIFIED else 1.0
    if subject.covered.claim is None:
        opinion = Opinion(Verdict.OUT_OF_SCOPE, subject.covered.gap)
    judged = JudgedQuantity(subject.quantity, finding(subject.covered, opinion, method=Method("paths", 3)))
    return judged, Grid(PathTests(p_value, 1.0, opinion.reason), p_value)
