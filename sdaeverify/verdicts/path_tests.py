"""What paths say of a claimed order: p-values, and by how much a sample must grow to decide."""

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

# A mean difference counts as resolved from so many standard errors on; no sample is ended by that.
# Level: p = 0.0074 of t_19, two-sided; it takes no share of alpha, as it decides no claim.
RESOLVED = 3.0
# No order shows on steps whose error is more than this part of what the solution does.
# Chosen.
COARSE = 0.25
# From this p-value on it matters whether a low order is one of coarse steps only.
# Level: 1 - confidence of the default run; it withholds verdicts and gives none.
SUSPECT = 0.01
# Jackknife intervals are calibrated from 100 paths on, to levels of 0.001; beyond, and for heavy tails, from 800.
# Measured by reports/calibration.
CALIBRATED_PATHS = 100
# Measured by reports/calibration.
DEEP_PATHS = 800
# Measured by reports/calibration.
SHALLOW = 0.001
# What paths alone verify leaves less of the error at the finest step to a term of half an order less. The squares of
# the two terms add, and the share of the lower one grows like 1/h: from a tenth on it is half of the squares at a
# ninth of the finest step, which is the range of the finer stages of a run (three halvings).
# Theorem: squares 0.1 to 0.9 at the finest step become equal at a ninth of it, as their ratio grows like 1/h.
LARGEST_SHARE = 0.1


def why_vacuous(most: float, size: float) -> Reason:
    """Return why a claimed bound says nothing, or an empty reason.

    An error as large as the quantity itself is granted by a bound that is no less than the size of the quantity: no
    evidence could speak against such a claim.

    Parameters
    ----------
    most : float
        The claimed bound.
    size : float
        Of the quantity; NaN or 0 if it is not known.
    """
    if not (size > 0.0 and most >= size):
        return Reason()
    text = "the claimed bound {most:g} is no less than the size of the quantity, {size:.2g}, so that it says nothing"
    return Reason(text, numbers={"most": most, "size": size})


class PathTests(NamedTuple):
    """What the paths say of a claim.

    Attributes
    ----------
    verified, refuted : float
        p-values of the two hypotheses which the verdicts reject; 1 where nothing can be rejected.
    reason : Reason
        The figures.
    growth : float
        By which factor the number of paths must grow to decide; infinite if more paths cannot.
    suspected : float
        Least p-value of what speaks against the claim: what `refuted` would be if the sample and its steps could be
        relied on. It asks for more paths or finer levels, and refutes nothing; nothing is verified in spite of it.
    blind : float
        By which factor the number of paths must grow until an error shows that is as large as the claim forbids; 1
        where it would show now, infinite if more paths do not help.
    limit : float
        The part of `refuted` that a wrong limit has. An order that is held back leaves it as it is; steps that are
        too coarse do not.
    remedy : Reason
        What would decide where that is not the number of paths that `growth` gives, such as a truth; empty if it is.
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
        """Least p-value of all that speaks against the claim, whether it may refute or not."""
        return min(self.refuted, self.suspected)

    def held(self, *why: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that refute nothing, for a reason; what they show stays suspicious."""
        reason = reduce(Reason.then, why, self.reason)
        remedy = self.remedy if isfinite(growth) else Reason()
        return self._replace(refuted=1.0, suspected=self.against, growth=growth, reason=reason, remedy=remedy)

    def unless_vacuous(self, most: float, size: float) -> "PathTests":
        """Return tests that verify nothing if a claimed bound is no less than the size of what it bounds.

        Parameters
        ----------
        most : float
            The claimed bound.
        size : float
            Of the quantity; NaN or 0 if it is not known.
        """
        reason = why_vacuous(most, size)
        return self._replace(verified=1.0, growth=inf, reason=reason.then(self.reason)) if reason else self

    def without_truth(self, level: float, truth: str, *, reached: bool) -> "PathTests":
        """Return tests that may refute and do not verify, because the problem has no truth to compare the limit with.

        Parameters
        ----------
        level : float
            Of a test: what is above the bound of the claim at this level needs no more paths.
        truth : str
            What has to be attached to the problem, in words.
        reached : bool
            Whether the estimate is as claimed: more paths do not refute then, if the figures stay.
        """
        growth = inf if self.verified <= level else self.growth
        remedy = ask_for_truth(truth) if reached or not isfinite(growth) else Reason()
        return self._replace(verified=1.0, growth=growth, remedy=remedy)

    @classmethod
    def none(cls, reason: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that reject nothing, and why."""
        return cls(1.0, 1.0, Reason.of(reason), growth)


def ask_for_truth(truth: str) -> Reason:
    """Return that a truth, and no number of paths, would decide.

    Parameters
    ----------
    truth : str
        What has to be attached to the problem, in words.
    """
    text = "no number of paths verifies this without a truth: attach {truth} to the problem"
    return Reason(text, Kind.TRUTH, {"truth": truth})


def order_tests(
    claim: Claim, order: Estimate, evidence: Evidence, bias: float = 0.0, of: str = "along paths"
) -> PathTests:
    """Compare an estimated order with a claimed least order.

    The claim is verified by rejecting order <= value - margin, provided that its interval at the run's confidence
    is no wider than the margin on either side, and refuted by rejecting order >= value - margin.

    Parameters
    ----------
    claim : Claim
        One that claims exactness is refuted: whoever asks for an order has seen more than rounding.
    order : Estimate
    evidence : Evidence
    bias : float
        Bound of the bias of the estimate.
    of : str, optional
        What the order is of, in words.

    Returns
    -------
    PathTests
    """
    claimed = claim.value
    if isinstance(claimed, Exact):
        return PathTests(1.0, 0.0, Reason("claimed exact, and errors along paths exceed round-off"))
    if not isinstance(claimed, Order):
        return PathTests.none(unknown_value(claim))
    bound = claimed.floor
    low, high = order.interval(evidence.settings.confidence, bias)
    if not (isfinite(low) and isfinite(high)):
        return PathTests.none("the interval of the order along paths is not finite")
    growth, half = order.growth_to_decide(bound, evidence.level, bias), 0.5 * (high - low)
    reason = order_in(order.value, low, high, claimed, of)
    above = order.p_above(bound, bias)
    if half > claimed.margin and above <= evidence.level:
        above, growth = 1.0, max(growth, (half / claimed.margin) ** 2 if bias < claimed.margin else inf)
    return PathTests(above, order.p_below(bound, bias), reason, growth)


def order_resolution(share: Estimate, confidence: float, bias: float = 0.0) -> float:
    """Return the largest share of a lower term that is not excluded, between 0 and 1; infinite if it is not known.

    Parameters
    ----------
    share : Estimate
        Of the error at the finest step.
    confidence : float
        Of the one-sided interval whose upper end is taken.
    bias : float, optional
        Bound of the bias of the share.
    """
    bound = share.upper_bound(confidence, bias)
    return min(max(bound, 0.0), 1.0) if isfinite(bound) else inf


def resolve_order(
    tests: PathTests, claimed: Order, share: Estimate, evidence: Evidence, bias: float = 0.0
) -> PathTests:
    """Verify no order while a term of half an order less may have a tenth of the error at the finest step.

    Shares above the upper end of a one-sided interval at the run's confidence are excluded. Where the share itself is
    no smaller than a tenth, finer steps decide, on which that of a lower order grows and that of a higher one falls.

    Parameters
    ----------
    tests : PathTests
        Of the claimed order, by paths alone.
    claimed : Order
    share : Estimate
        Of the lower term; see `Slopes.lower_share`.
    evidence : Evidence
    bias : float
        Bound of the bias of the share.

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
    text = "a term of order {lower:g} may be {seen:.0%} of the error at the finest step, {most:.0%} is allowed"
    figures = {"lower": claimed.least - 0.5, "seen": min(seen, 1.0), "most": LARGEST_SHARE}
    doubt = tests.reason.then(Reason(text, Kind.LOWER_ORDER, figures), ", but ")
    reason = doubt.then(Reason("finer steps would decide", Kind.FINER)) if finer else doubt
    return tests._replace(verified=1.0, growth=growth, reason=reason)


def order_in(order: float, low: float, high: float, claimed: Order, of: str = "along paths") -> Reason:
    """Return an order with its interval, beside what is claimed.

    Parameters
    ----------
    order, low, high : float
        Estimate and ends of its interval.
    claimed : Order
    of : str, optional
        What the order is of.
    """
    text = "order {of} {order:.2f} [{low:.2f}, {high:.2f}]; {bar}"
    figures = {"of": of, "order": order, "low": low, "high": high, "claimed": claimed.least, "bar": claimed.bar}
    return Reason(text, Kind.ORDER, figures)


def unknown_value(claim: Claim) -> Reason:
    """Return that a measure has no test for what is claimed."""
    text = "not tested: this measure has no test of the claim {value!r}"
    return Reason(text, Kind.UNKNOWN_VALUE, {"value": str(claim)})


def with_sample(tests: PathTests, paths: int, *, heavy: bool) -> PathTests:
    """Reject nothing at levels for which the sample is too small, or too much on few paths, to be calibrated.

    Parameters
    ----------
    tests : PathTests
    paths : int
        How many were sampled.
    heavy : bool
        Whether the tails of the errors are heavy.
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

    They do not where the slope is below claim - margin; nor where it is nearer to that than to the claim, unless
    what it tends to with a further term of the expansion is not.

    Parameters
    ----------
    claimed : Order
    slope, corrected : Estimate
        On the finest levels; with a further term.
    bias : float
        By how much the true slope may be larger than it is found.
    """
    middle = claimed.least - 0.5 * claimed.margin
    nearer = max(slope.p_below(middle, bias), corrected.p_below(middle, bias))
    return min(slope.p_below(claimed.floor, bias), nearer)


def hold_back(
    tests: PathTests, evidence: Evidence, levels: Array, coarse: str = "", growth: float = inf
) -> PathTests:
    """Refute nothing by levels that are too coarse for the problem, see `why_not_resolved`; that stays suspicious.

    Nor by levels that look too coarse for another reason, which so many times as many paths would make sure of. More
    paths on the same steps do not decide what is held back.

    Parameters
    ----------
    tests : PathTests
        Of a claim, along paths.
    evidence : Evidence
        Of its cell.
    levels : ndarray of int
        Levels that the tests use.
    coarse : str
        Another reason why they look too coarse; empty if there is none.
    growth : float
        How many times as many paths would make sure of it.
    """
    if tests.against == 1.0:
        return tests
    finest = min(evidence.step_sizes[level] for level in levels)
    why = why_not_resolved(evidence.view, finest) or why_lost(evidence, levels) or coarse
    if not why:
        return tests
    held = tests.held(why, growth=growth if tests.against <= SUSPECT else tests.growth)
    # Steps that do not follow the equation are as far from its limit.
    return held._replace(limit=1.0)


def why_lost(evidence: Evidence, levels: Array) -> str:
    """Return that paths are lost on steps hardly longer than those that are left; empty if it is not so.

    Paths that all but explode carry the errors there, and an order shows on steps that keep clear of them.
    """
    lost = evidence.health.sums["lost"][: levels[0]]
    if len(levels) >= FITTED or not lost.any():
        return ""
    return f"{at_levels('paths are lost', lost > 0)}, {len(levels)} are left: take finer steps"
