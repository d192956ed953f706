"""Tests of a claimed order on paths: p-values, and the factor by which a sample must grow to decide."""

from functools import reduce
from math import inf, isfinite
from typing import NamedTuple

from ..arrays import Array
from ..contracts.claimed import Exact, Order
from ..contracts.finding import Kind, Reason
from ..contracts.measure import Evidence
from ..contracts.scheme import Claim
from ..numerics.statistics import Estimate
from ..probe.step.one_step import why_not_resolved
from .fitted_levels import FITTED, at_levels

# Standard errors from which a mean difference counts as resolved; sampling does not stop because of it.
# Level: p = 0.0074 of t_19, two-sided; it takes no share of alpha, as it decides no claim.
RESOLVED = 3.0
# Largest error of a step, as part of the motion of the solution, at which an order can show.
# Chosen.
COARSE = 0.25
# p-value below which a contradiction counts: it then matters whether a low order is due to coarse steps only.
# Level: 1 - confidence of the default run; it withholds verdicts and gives none.
SUSPECT = 0.01
# Jackknife intervals are calibrated from 100 paths on, to levels of 0.001; beyond, and for heavy tails, from 800.
# Measured by reports/calibration.
CALIBRATED_PATHS = 100
# Measured by reports/calibration.
DEEP_PATHS = 800
# Measured by reports/calibration.
SHALLOW = 0.001
# Largest share of the error at the finest step that a term of half an order less may have. The squares of the two
# terms add, and the share of the lower one grows like 1/h: from a tenth on, it is half of the squares at a ninth of
# the finest step, which is the range of the finer stages of a run (three halvings).
# Theorem: squares 0.1 to 0.9 at the finest step become equal at a ninth of it, as their ratio grows like 1/h.
LARGEST_SHARE = 0.1


def why_vacuous(most: float, size: float) -> Reason:
    """Return why a claimed bound cannot be contradicted, or an empty reason.

    A bound no smaller than the size of the quantity permits an error as large as the quantity, so that no evidence
    could contradict the claim.

    Parameters
    ----------
    most : float
        Claimed bound.
    size : float
        Size of the quantity; NaN or 0 if unknown.
    """
    if not (size > 0.0 and most >= size):
        return Reason()
    text = "the claimed bound {most:g} is not below the size of the quantity, {size:.2g}, so that no error exceeds it"
    return Reason(text, numbers={"most": most, "size": size})


class PathTests(NamedTuple):
    """Hold the p-values of a claim on paths, and how many more paths would decide it.

    Attributes
    ----------
    verified, refuted : float
        p-values of the null hypotheses whose rejection verifies or refutes the claim; 1 if they cannot be rejected.
    reason : Reason
        Estimates and intervals in words.
    growth : float
        Factor by which the number of paths must grow to decide; infinite if more paths cannot decide.
    suspected : float
        Least p-value against the claim: the value of `refuted` if the sample and its step sizes could be relied on.
        It requests more paths or finer levels and bars verification, but does not refute.
    blind : float
        Factor by which the number of paths must grow to show an error as large as the claim forbids; 1 if it would
        show now, infinite if more paths do not help.
    limit : float
        p-value against the limit of the quantity alone. It stays when an order is held back, and is 1 when steps are
        too coarse.
    remedy : Reason
        Evidence that would decide instead of more paths, such as a truth; empty if `growth` applies.
    """

    verified: float
    refuted: float
    reason: Reason
    growth: float = inf
    suspected: float = 1.0
    blind: float = 1.0
    limit: float = 1.0
    remedy: Reason = Reason()

    @property
    def against(self) -> float:
        """Least p-value against the claim, of refuting and merely suspicious evidence."""
        return min(self.refuted, self.suspected)

    def held(self, *why: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that do not refute, for given reasons; the smallest p-value moves to `suspected`."""
        reason = reduce(Reason.then, why, self.reason)
        remedy = self.remedy if isfinite(growth) else Reason()
        return self._replace(refuted=1.0, suspected=self.against, growth=growth, reason=reason, remedy=remedy)

    def unless_vacuous(self, most: float, size: float) -> "PathTests":
        """Return tests that do not verify if the claimed bound is no smaller than the bounded quantity.

        Parameters
        ----------
        most : float
            Claimed bound.
        size : float
            Size of the quantity; NaN or 0 if unknown.
        """
        reason = why_vacuous(most, size)
        return self._replace(verified=1.0, growth=inf, reason=reason.then(self.reason)) if reason else self

    def without_truth(self, level: float, truth: str, *, reached: bool) -> "PathTests":
        """Return tests that may refute but not verify, for a problem without a truth of the limit.

        Parameters
        ----------
        level : float
            Level of a test. An estimate above the bound of the claim at this level needs no more paths.
        truth : str
            Truth that has to be attached to the problem, in words.
        reached : bool
            Whether the estimate agrees with the claim, so that more paths would not refute it either.
        """
        growth = inf if self.verified <= level else self.growth
        remedy = ask_for_truth(truth) if reached or not isfinite(growth) else Reason()
        return self._replace(verified=1.0, growth=growth, remedy=remedy)

    @classmethod
    def none(cls, reason: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that reject no hypothesis, with the reason."""
        return cls(1.0, 1.0, Reason.of(reason), growth)


def ask_for_truth(truth: str) -> Reason:
    """Return the reason that only a truth would decide, and no number of paths.

    Parameters
    ----------
    truth : str
        Truth that has to be attached to the problem, in words.
    """
    text = "no number of paths can verify the claim unless {truth} is attached to the problem"
    return Reason(text, Kind.TRUTH, {"truth": truth})


def order_tests(
    claim: Claim, order: Estimate, evidence: Evidence, bias: float = 0.0, of: str = "along paths"
) -> PathTests:
    """Compare an estimated order with a claimed least order.

    The claim is verified by rejecting order <= value - margin, provided that the interval at the run's confidence is
    no wider than the margin on either side, and refuted by rejecting order >= value - margin.

    Parameters
    ----------
    claim : Claim
        A claim of exactness is refuted, because an order is only estimated from errors above round-off.
    order : Estimate
    evidence : Evidence
    bias : float
        Bound on the bias of the estimate.
    of : str, optional
        Sense of the order, in words.

    Returns
    -------
    PathTests
    """
    claimed = claim.value
    if isinstance(claimed, Exact):
        return PathTests(1.0, 0.0, Reason("the scheme is claimed exact, but errors along paths exceed round-off"))
    if not isinstance(claimed, Order):
        return PathTests.none(unknown_value(claim))
    bound = claimed.floor
    low, high = order.interval(evidence.settings.confidence, bias)
    # The interval is symmetric: both of its ends are finite, or neither.
    if not isfinite(high):
        return PathTests.none("the interval of the order along paths is not finite")
    growth, half = order.growth_to_decide(bound, evidence.level, bias), 0.5 * (high - low)
    reason = order_in(order.value, low, high, claimed, of)
    above = order.p_above(bound, bias)
    if half > claimed.margin and above <= evidence.level:
        above, growth = 1.0, max(growth, (half / claimed.margin) ** 2 if bias < claimed.margin else inf)
    return PathTests(above, order.p_below(bound, bias), reason, growth)


def order_resolution(share: Estimate, confidence: float, bias: float = 0.0) -> float:
    """Return the upper confidence bound on the share of a lower-order term, clipped to [0, 1].

    The result is infinite if the bound is not finite.

    Parameters
    ----------
    share : Estimate
        Share of the term in the error at the finest step.
    confidence : float
        Confidence of the one-sided interval.
    bias : float, optional
        Bound on the bias of the share.
    """
    bound = share.upper_bound(confidence, bias)
    return min(max(bound, 0.0), 1.0) if isfinite(bound) else inf


def resolve_order(
    tests: PathTests, claimed: Order, share: Estimate, evidence: Evidence, bias: float = 0.0
) -> PathTests:
    """Withhold verification while a term of half an order less may have a tenth of the error at the finest step.

    Shares above the upper end of a one-sided interval at the run's confidence are excluded. If the estimated share is
    itself a tenth or more, finer steps decide, because there the share of a lower order grows and that of a higher
    falls.

    Parameters
    ----------
    tests : PathTests
        Tests of the claimed order on paths alone.
    claimed : Order
    share : Estimate
        Share of the lower term; see `Slopes.lower_share`.
    evidence : Evidence
    bias : float
        Bound on the bias of the share.

    Returns
    -------
    PathTests
    """
    confidence = evidence.settings.confidence
    seen = order_resolution(share, confidence, bias)
    if seen < LARGEST_SHARE:
        return tests
    if tests.verified > evidence.level:
        return tests._replace(verified=1.0)
    finer = not share.value + bias < LARGEST_SHARE
    growth = inf if finer else share.growth_to_decide(LARGEST_SHARE, 1.0 - confidence, bias)
    text = "a term of order {lower:g} may make up {seen:.0%} of the error at the finest step, {most:.0%} is allowed"
    figures = {"lower": claimed.least - 0.5, "seen": min(seen, 1.0), "most": LARGEST_SHARE}
    doubt = tests.reason.then(Reason(text, Kind.LOWER_ORDER, figures), ", but ")
    reason = doubt.then(Reason("finer steps would decide", Kind.FINER)) if finer else doubt
    return tests._replace(verified=1.0, growth=growth, reason=reason)


def order_in(order: float, low: float, high: float, claimed: Order, of: str = "along paths") -> Reason:
    """Return an estimated order with its interval and the claimed bar, as a reason.

    Parameters
    ----------
    order, low, high : float
        Estimate and ends of its interval.
    claimed : Order
    of : str, optional
        Sense of the order, in words.
    """
    text = "order {of} {order:.2f} [{low:.2f}, {high:.2f}]; {bar}"
    figures = {"of": of, "order": order, "low": low, "high": high, "claimed": claimed.least, "bar": claimed.bar}
    return Reason(text, Kind.ORDER, figures)


def unknown_value(claim: Claim) -> Reason:
    """Return the reason that a measure has no test for the claimed value."""
    text = "not tested: this measure has no test for the claimed value {value!r}"
    return Reason(text, Kind.UNKNOWN_VALUE, {"value": str(claim)})


def with_sample(tests: PathTests, paths: int, *, heavy: bool) -> PathTests:
    """Limit p-values to the levels for which intervals are calibrated at this sample size.

    With fewer than `CALIBRATED_PATHS` paths, no hypothesis is rejected.

    Parameters
    ----------
    tests : PathTests
    paths : int
        Number of sampled paths.
    heavy : bool
        Whether the errors have heavy tails, in which case fewer than `DEEP_PATHS` paths do not refute.
    """
    if paths < CALIBRATED_PATHS:
        few = f"{paths} paths are too few for an interval, {CALIBRATED_PATHS} are needed"
        return PathTests.none(few, CALIBRATED_PATHS / paths)
    if paths >= DEEP_PATHS:
        return tests
    refuted, limit = (1.0 if heavy else max(p, SHALLOW) for p in (tests.refuted, tests.limit))
    return tests._replace(
        verified=max(tests.verified, SHALLOW),
        refuted=refuted,
        growth=max(tests.growth, DEEP_PATHS / paths) if isfinite(tests.growth) else inf,
        suspected=tests.against,
        limit=limit,
    )


def unlike(claimed: Order, slope: Estimate, corrected: Estimate, bias: float = 0.0) -> float:
    """Return the p-value of the hypothesis that errors look like a claimed order.

    The hypothesis fails if the slope is below claim - margin, or if both the slope and its corrected estimate are
    nearer to claim - margin than to the claim.

    Parameters
    ----------
    claimed : Order
    slope, corrected : Estimate
        Slope on the finest levels, and its limit estimated with a further term of the expansion.
    bias : float
        Bound on how far the estimated slope may lie below the true one.
    """
    middle = claimed.least - 0.5 * claimed.margin
    nearer = max(slope.p_below(middle, bias), corrected.p_below(middle, bias))
    return min(slope.p_below(claimed.floor, bias), nearer)


def hold_back(
    tests: PathTests, evidence: Evidence, levels: Array, coarse: str = "", growth: float = inf
) -> PathTests:
    """Withhold refutation by levels that are too coarse for the problem, see `why_not_resolved`.

    Refutation is also withheld if levels look too coarse for another reason, which `growth` times as many paths would
    confirm. The p-values remain as suspicion. More paths on the same steps do not decide a claim that is held back.

    Parameters
    ----------
    tests : PathTests
        Tests of a claim on paths.
    evidence : Evidence
        Evidence of the cell.
    levels : ndarray of int
        Levels that the tests use.
    coarse : str
        Another reason why the levels look too coarse; empty if there is none.
    growth : float
        Factor by which the number of paths must grow to confirm `coarse`.
    """
    if tests.against == 1.0:
        return tests
    finest = min(evidence.step_sizes[level] for level in levels)
    why = why_not_resolved(evidence.view, finest) or why_lost(evidence, levels) or coarse
    if not why:
        return tests
    held = tests.held(why, growth=growth if tests.against <= SUSPECT else tests.growth)
    # Steps that do not follow the equation are equally far from its limit.
    return held._replace(limit=1.0)


def why_lost(evidence: Evidence, levels: Array) -> str:
    """Return the reason that paths are lost on step sizes hardly longer than the fitted ones, or an empty string.

    Near-exploding paths dominate the errors there, and an order shows only on steps far from the loss.
    """
    lost = evidence.health.sums["lost"][: levels[0]]
    if len(levels) >= FITTED or not lost.any():
        return ""
    return f"{at_levels('paths are lost', lost > 0)}, only {len(levels)} remain: take finer steps"
