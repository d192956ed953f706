"""What becomes of a claim of uniform convergence: a component's findings on the grid and in continuous time."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.measure import Evidence, Finding, Verdict
from ...contracts.scheme import Claim
from ...numerics.statistics import slope_weights
from ...probe.local.orders import LocalOpinion
from ..judge import FEWEST, FITTED, WRONG, Decision, Tests, at_levels, claim_for, decide, order_tests, unfitted
from ..path_errors.order import (
    EXACT,
    RIGHT_LIMIT,
    STILL,
    Fit,
    calibrated,
    fit,
    is_exact,
    path_tests,
    rises,
    stands_still,
    usable_levels,
)
from ..path_errors.quantity import Quantity
from ..path_errors.reference_bias import Bias

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


CONVERGES = "converges"
# A slower fall cannot be told from none over a few halvings.
FALLING = 0.1
LEVELLED = 0.5
SHOWS = "a limit nearer than a third of that would not show, nor what happens below it"


class Grid(NamedTuple):
    """What is known of a component on the grid.

    Attributes
    ----------
    tests : Tests
        Of its claim.
    limit : float
        p-value of the hypothesis that it tends to a wrong limit; 1 where that cannot be told.
    """

    tests: Tests
    limit: float


def levels_for(evidence: Evidence, quantity: Quantity, claim: Claim | None) -> tuple[Array, str]:
    """Return the levels that can be fitted, and what is to be said of levels.

    A theorem on convergence is about the scheme with its truncation: truncated levels count, and are named.
    """
    if claim is None or claim.value != CONVERGES:
        return usable_levels(evidence, quantity)
    sums = evidence.health.sums
    truncated = sums["truncated"] > 0
    untouched: Mapping[str, Array] = {**sums, "truncated": np.zeros_like(sums["truncated"])}
    usable, left_out = usable_levels(replace(evidence, health=replace(evidence.health, sums=untouched)), quantity)
    named = at_levels("truncated steps", truncated) if truncated.any() else ""
    return usable, "; ".join(text for text in (left_out, named) if text)


def grid_tests(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim) -> Tests:
    """Return what errors on the grid say of a claim: of convergence or of an order."""
    if claim.value != CONVERGES:
        return path_tests(evidence, quantity, fitted, claim)
    if not np.isfinite(fitted.bias.bound):
        return Tests.none(f"no finite interval: {fitted.bias.reference} is too coarse or not finite")
    tests = falling(evidence, quantity, fitted)
    if fitted.bias.knows_limit:
        tests = _with_plateau(evidence, quantity, fitted, tests)
    else:
        tests = _towards_its_own(evidence, tests)
    return calibrated(tests, quantity, fitted.levels)


def limit_test(quantity: Quantity, fitted: Fit) -> float:
    """Return the p-value of the hypothesis that errors leave successive differences behind: of a wrong limit."""
    if not fitted.bias.knows_limit:
        return 1.0
    return quantity.contrast(fitted.levels).p_above(RIGHT_LIMIT, fitted.bias.bound)


def continuous_tests(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim, grid: Grid) -> Tests:
    """Return what errors in continuous time say of a claim.

    Convergence needs no bound of the bias. An error is at most the distance from the finest paths and the error of
    these: the first has to fall here, the second on the grid, where the limit is told as well.
    """
    if claim.value == CONVERGES:
        unbiased = fitted._replace(bias=fitted.bias._replace(bound=0.0))
        grown = falling(evidence, quantity, fitted).refuted
        tests = falling(evidence, quantity, unbiased)._replace(refuted=min(1.0, 2.0 * min(grown, grid.tests.refuted)))
        needed, why = max(grid.limit, grid.tests.verified), "that the errors on the grid fall to 0"
    elif not np.isfinite(fitted.bias.bound):
        return Tests.none(f"no finite interval: {fitted.bias.reference}")
    else:
        tests = order_tests(claim, fitted.slope, evidence, fitted.bias.bound)
        needed, why = grid.limit, "the right limit"
    if needed > evidence.level:
        growth = max(tests.growth, grid.tests.growth)
        tests = tests._replace(reason=f"{why} is not shown (p = {needed:.2g}); {tests.reason}", growth=growth)
    return calibrated(tests._replace(verified=max(tests.verified, needed)), quantity, fitted.levels)


def falling(evidence: Evidence, quantity: Quantity, fitted: Fit) -> Tests:
    """Return the tests of a fall of errors, and of their growth."""
    slope, bias, last = fitted.slope, fitted.bias.bound, fitted.levels[-1]
    low, high = slope.interval(evidence.settings.confidence, bias)
    if not np.isfinite([low, high]).all():
        return Tests.none("no finite interval")
    size = f"{quantity.means()[last]:.2g} at h = {quantity.h[last]:.3g}"
    reason = f"errors go with h^{slope.value:.2f}, at least {low:.2f} and at most {high:.2f}, to {size}; {SHOWS}"
    growth = slope.growth_to_decide(FALLING, evidence.level, bias)
    grown = slope.p_below(0.0, bias)
    if not _may_refute(evidence, fitted) or rises(evidence, quantity, fitted):
        grown = 1.0
    return Tests(slope.p_above(FALLING, bias), grown, reason, growth)


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


def _with_plateau(evidence: Evidence, quantity: Quantity, fitted: Fit, tests: Tests) -> Tests:
    bias, confidence = fitted.bias.bound, evidence.settings.confidence
    contrast, right = quantity.contrast(fitted.levels), limit_test(quantity, fitted)
    levelled = quantity.contrast(fitted.levels, LEVELLED).p_below(0.0, bias) if _may_refute(evidence, fitted) else 1.0
    reason, growth = tests.reason, tests.growth
    if levelled <= 0.5 * evidence.level:
        reason = f"{WRONG}: errors level off, falling less than half as fast as successive differences; {reason}"
    elif tests.verified <= evidence.level < right:
        low = contrast.interval(confidence, bias)[0]
        reason = f"contrast at least {low:.3f}, of a right limit above {RIGHT_LIMIT}; {reason}"
        growth = max(growth, contrast.growth_to_decide(RIGHT_LIMIT, evidence.level, bias))
    return Tests(max(tests.verified, right), min(1.0, 2.0 * min(tests.refuted, levelled)), reason, growth)


def _towards_its_own(evidence: Evidence, tests: Tests) -> Tests:
    growth = np.inf if tests.verified <= evidence.level else tests.growth
    return tests._replace(verified=1.0, growth=growth, reason=f"towards its own limit, {tests.reason}")


def _may_refute(evidence: Evidence, fitted: Fit) -> bool:
    return not (evidence.health.sums["truncated"][fitted.levels] > 0).any()


MEASURE = "uniform"


class Judged(NamedTuple):
    """The finding on a quantity, and the levels that its slope was fitted on."""

    quantity: Quantity
    finding: Finding
    fitted: frozenset[int] = frozenset()


class _Asked(NamedTuple):
    """A quantity, the claim about it, and what one step says."""

    evidence: Evidence
    quantity: Quantity
    claim: Claim | None
    no_claim: str
    local: LocalOpinion | None


def judged_pair(
    evidence: Evidence, grid: Quantity, between: Quantity, local: LocalOpinion | None
) -> tuple[Judged, Judged]:
    """Judge a component on the grid, and in continuous time with what the grid says of its limit.

    Parameters
    ----------
    evidence : Evidence
    grid, between : Quantity
    local : LocalOpinion or None
        Whether one step follows the equation; None where that cannot be told.

    Returns
    -------
    Judged
        On the grid.
    Judged
        In continuous time.
    """
    on_grid, known = _on_grid(_asked(evidence, grid, local))
    return on_grid, _in_continuous_time(_asked(evidence, between, local), known, float(grid.means()[-1]))


def _asked(evidence: Evidence, quantity: Quantity, local: LocalOpinion | None) -> _Asked:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, MEASURE, quantity.name)
    return _Asked(evidence, quantity, claim, no_claim, local)


def _on_grid(asked: _Asked) -> tuple[Judged, Grid]:
    evidence, quantity, claim = asked.evidence, asked.quantity, asked.claim
    if is_exact(evidence, quantity):
        return _exact(asked)
    usable, remarks = levels_for(evidence, quantity, claim)
    if len(usable[-FITTED:]) < FEWEST:
        return Judged(quantity, unfitted(evidence, quantity.name, claim, remarks)), Grid(Tests.none(remarks), 1.0)
    fitted = fit(evidence, quantity, usable, remarks)
    tests = grid_tests(evidence, quantity, fitted, claim) if claim else Tests.none("")
    confidence = evidence.settings.confidence
    contrast = quantity.contrast(fitted.levels)
    low, high = contrast.interval(confidence)
    details = {"contrast": contrast.value, "contrast_low": low, "contrast_high": high}
    return _judged(asked, fitted, tests, details), Grid(tests, limit_test(quantity, fitted))


def _in_continuous_time(asked: _Asked, grid: Grid, finest_error: float) -> Judged:
    evidence, quantity, claim = asked.evidence, asked.quantity, asked.claim
    usable, remarks = levels_for(evidence, quantity, claim)
    levels = usable[-FITTED:]
    if len(levels) < FEWEST:
        return Judged(quantity, unfitted(evidence, quantity.name, claim, remarks or "there are too few"))
    bias = finest_as_reference(quantity, levels, finest_error)
    fitted = Fit(usable, levels, remarks, quantity.slope(levels), bias)
    tests = continuous_tests(evidence, quantity, fitted, claim, grid) if claim else Tests.none("")
    return _judged(asked, fitted, tests, {})


def _judged(asked: _Asked, fitted: Fit, tests: Tests, details: Mapping[str, object]) -> Judged:
    quantity, bias = asked.quantity, fitted.bias
    decision = _decision(asked, tests)
    low, high = fitted.slope.interval(asked.evidence.settings.confidence, bias.bound)
    reason = "; ".join(text for text in (decision.reason if asked.claim else asked.no_claim, fitted.left_out) if text)
    finding = Finding(
        quantity=quantity.name,
        claim=asked.claim,
        estimate=fitted.slope.value,
        low=low,
        high=high,
        method="local consistency (T1)" if decision.tier == 1 else f"paths, {bias.reference} (T3)",
        details={
            "std_error": fitted.slope.se,
            "order_L2": quantity.slope(fitted.levels, 2).value,
            "order_L4": quantity.slope(fitted.levels, 3).value,
            "fitted_levels": len(fitted.levels),
            "bias_bound": bias.bound,
            **details,
        },
        **decision._replace(reason=reason)._asdict(),
    )
    return Judged(quantity, finding, frozenset(fitted.levels.tolist()))


def _decision(asked: _Asked, tests: Tests) -> Decision:
    """Return the verdict of the paths, unless a single step is wrong already."""
    if asked.claim is None:
        return Decision(Verdict.OUT_OF_SCOPE, "", 3)
    local = asked.local
    if local is not None and local.verdict is Verdict.REFUTED:
        return Decision(local.verdict, local.reason, 1)
    decision = decide(tests, asked.evidence)
    return decision if local is None else decision._replace(reason=f"{decision.reason}; {local.reason}")


def _exact(asked: _Asked) -> tuple[Judged, Grid]:
    still = stands_still(asked.evidence, asked.quantity)
    reason, verdict = (STILL, Verdict.INCONCLUSIVE) if still else (EXACT, Verdict.VERIFIED)
    if asked.claim is None:
        reason, verdict = asked.no_claim, Verdict.OUT_OF_SCOPE
    finding = Finding(
        quantity=asked.quantity.name, verdict=verdict, reason=reason, claim=asked.claim, method="paths (T3)"
    )
    # The limit is known to rounding.
    p_value = 1.0 if still else 0.0
    return Judged(asked.quantity, finding), Grid(Tests(p_value, 1.0, reason), p_value)
