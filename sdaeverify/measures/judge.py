"""The way from a claim to a finding: what the evidence says of the claim, and what guards that."""

from collections.abc import Callable, Container
from functools import reduce
from math import inf, isfinite
from typing import Any, NamedTuple

from ..arrays import Array
from ..contracts.coverage import ROUND_OFF, Coverage
from ..contracts.finding import Finding, Judgement, Kind, Opinion, Reason, Verdict
from ..contracts.measure import Evidence
from ..contracts.scheme import Claim
from ..numerics.statistics import Estimate
from ..probe.local.delay_links import remove_delay
from ..probe.local.smoothness import rough_coefficient
from ..probe.step.one_step import why_unresolved
from .sound_levels import at_levels

# A slope is fitted on so many of the finest levels; fewer than FEWEST tell none.
FITTED = 4
FEWEST = 3
# A mean difference counts as resolved from so many standard errors on; no sample is ended by that.
RESOLVED = 3.0
# No order shows on steps whose error is more than this part of what the solution does.
COARSE = 0.25
# From this p-value on it matters whether a low order is one of coarse steps only.
SUSPECT = 0.01
# Jackknife intervals are calibrated from 100 paths on, to levels of 0.001; beyond, and for heavy tails, from 800.
CALIBRATED_PATHS = 100
DEEP_PATHS = 800
# For which no coefficient needs derivatives.
LIPSCHITZ_ORDER = 0.5
SHALLOW = 0.001


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
        The part of `refuted` that a wrong limit has: what is held back of an order leaves it as it is.
    """

    verified: float
    refuted: float
    reason: Reason
    growth: float = inf
    suspected: float = 1.0
    blind: float = 1.0
    limit: float = 1.0

    @property
    def against(self) -> float:
        """Least p-value of all that speaks against the claim, whether it may refute or not."""
        return min(self.refuted, self.suspected)

    def held(self, *why: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that refute nothing, for a reason; what they show stays suspicious."""
        reason = reduce(Reason.then, why, self.reason)
        return self._replace(refuted=1.0, suspected=self.against, growth=growth, reason=reason)

    @classmethod
    def none(cls, reason: Reason | str, growth: float = inf) -> "PathTests":
        """Return tests that reject nothing, and why."""
        return cls(1.0, 1.0, Reason.of(reason), growth)


def judge_claim(
    covered: Coverage, judge: Callable[[Claim], Opinion], words: Container[str] = (), tier: int = 3
) -> Opinion:
    """Return the opinion on a claim; out of scope where there is none, undecided where its value is not known.

    Parameters
    ----------
    covered : Coverage
    judge : callable, Claim -> Opinion
    words : container of str
        Values that the measure knows; if left out, it knows orders.
    tier : int
        Of an opinion without a judgement.
    """
    claim = covered.claim
    if claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, covered.gap, tier)
    if claim.value in words if words else is_order(claim):
        return judge(claim)
    return Opinion(Verdict.INCONCLUSIVE, unknown_value(claim), tier)


def leave_open(covered: Coverage, reason: Reason | str) -> Opinion:
    """Return that a claim, if there is one, is not decided, and why."""
    undecided = Opinion(Verdict.INCONCLUSIVE, Reason.of(reason))
    return undecided if covered.claim else Opinion(Verdict.OUT_OF_SCOPE, covered.gap)


def local_opinion(verdict: Verdict, text: str, kind: str = Kind.PLAIN) -> Opinion:
    """Return what one step says (T1).

    Parameters
    ----------
    verdict : Verdict
    text : str
        The reason in words.
    kind : str, optional
        Reasons of one kind say the same with other numbers.
    """
    return Opinion(verdict, Reason(text, kind), 1)


def local_doubt(text: str, kind: str = Kind.PLAIN, *, against: bool = False) -> Opinion:
    """Return that one step does not decide, and why.

    Parameters
    ----------
    text : str
        The reason in words.
    kind : str, optional
        Of the reason; one step that does not follow the equation speaks against all claims of the scheme there.
    against : bool, optional
        Whether it speaks against the claim all the same, so that paths do not verify it; it says nothing if left out.
    """
    found = local_opinion(Verdict.INCONCLUSIVE, text, kind)
    return found._replace(excluded=frozenset({Verdict.VERIFIED})) if against else found


def of_smooth(opinion: Opinion, claim: float, evidence: Evidence) -> Opinion:
    """Return what a local order says of a claim: nothing for it where a coefficient is not smooth enough.

    Order 1/2 needs Lipschitz coefficients alone (Milstein 1988, Theorem 1).

    Parameters
    ----------
    opinion : Opinion
        Of one step.
    claim : float
        The order that is claimed.
    evidence : Evidence
        Of its cell.
    """
    if opinion.verdict is not Verdict.VERIFIED:
        return opinion
    rough = rough_coefficient(remove_delay(evidence.scheme, evidence.view)[1])
    if rough is None or (rough.lipschitz and claim <= LIPSCHITZ_ORDER):
        return opinion
    return local_doubt(f"{opinion.reason}, if coefficients are smooth: {rough} where solutions go")


def is_order(claim: Claim) -> bool:
    """Tell whether a claim is one of an order, and not in words."""
    return not isinstance(claim.value, str)


def unknown_value(claim: Claim) -> Reason:
    """Return that a measure has no test for what is claimed."""
    text = "this measure does not know what {value!r} means"
    return Reason(text, Kind.UNKNOWN_VALUE, {"value": claim.value})


def finding(covered: Coverage, opinion: Opinion, **shown: Any) -> Finding:
    """Return the row of a quantity: its claim, the opinion on it, and what is shown beside; see `Finding`.

    Parameters
    ----------
    covered : Coverage
        The quantity and its claim.
    opinion : Opinion
        Verdict and reason.
    **shown
        Fields of `Finding` and details of the measure, such as ``estimate`` and ``method``.
    """
    return Finding(quantity=covered.quantity, claim=covered.claim, **opinion._asdict(), **shown)


NOT_PROBED = Judgement(
    (Finding(quantity="", verdict=Verdict.INCONCLUSIVE, reason=Reason("not probed")),),
    (),
)


def decide(tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of the paths alone: they verify nothing that they speak against as well."""
    found, doubted = Verdict.INCONCLUSIVE, tests.suspected <= SUSPECT
    if tests.refuted <= evidence.level:
        found = Verdict.REFUTED
    elif tests.verified <= evidence.level and not doubted:
        found = Verdict.VERIFIED
    more = found is Verdict.INCONCLUSIVE and isfinite(tests.growth)
    paths = tests.growth * evidence.paths
    needed = _ask_for_paths("about {paths} paths would decide", paths) if more else ""
    settled = not more or _beyond_budget(evidence, paths)
    opinion = Opinion(found, tests.reason.then(needed), 3, settled, tests.verified, tests.refuted)
    return opinion._replace(p_verified=1.0, excluded=frozenset({Verdict.VERIFIED})) if doubted else opinion


def guard(local: Opinion | None, tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of a deterministic tier, guarded by the paths; theirs alone where it has none.

    What is refuted without sampling stays so. What is verified needs paths that could be compared, that would show an
    error which the claim forbids, and that do not refute it. Where they look as if they might, or are too few to show
    anything, more of them are asked for, and without more nothing is decided.

    Parameters
    ----------
    local : Opinion or None
        What one step says; None where it was not asked.
    tests : PathTests
        What paths say.
    evidence : Evidence
    """
    if local is None or local.verdict is Verdict.INCONCLUSIVE:
        return beside(local, decide(tests, evidence))
    if local.verdict is Verdict.REFUTED:
        return local
    if tests.refuted <= evidence.level:
        reason = tests.reason.then(local.reason, ", although ")
        return Opinion(Verdict.REFUTED, reason, 3, p_refuted=tests.refuted)
    doubt, settled = _doubt(tests, evidence)
    if doubt:
        reason = local.reason.then(doubt, ", but ")
        return Opinion(Verdict.INCONCLUSIVE, reason, 3, settled, p_refuted=tests.refuted)
    return local._replace(p_refuted=tests.refuted)


def beside(local: Opinion | None, opinion: Opinion) -> Opinion:
    """Return what paths say of a claim that one step leaves open: they do not verify what it speaks against.

    Parameters
    ----------
    local : Opinion or None
        An inconclusive one of one step; None where it was not asked.
    opinion : Opinion
        Of the paths.
    """
    if local is None:
        return opinion
    if not local.speaks_against:
        return opinion.plus(local.reason)
    if opinion.verdict is Verdict.VERIFIED:
        reason = local.reason.then(opinion.reason, ", although ")
        opinion = opinion._replace(verdict=Verdict.INCONCLUSIVE, reason=reason)
    else:
        opinion = opinion.plus(local.reason)
    return opinion._replace(p_verified=1.0, excluded=opinion.excluded | local.excluded)


def _doubt(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool]:
    """Return why paths that refute nothing are no guard, or an empty reason, and whether more of them do not help."""
    paths = {"paths": evidence.paths}
    if evidence.paths < CALIBRATED_PATHS:
        return Reason("{paths} paths are too few to guard it", Kind.GUARD, paths), True
    if tests.against <= 1.0 - evidence.settings.confidence:
        unlike = Reason("the paths do not look like it", Kind.GUARD).then(tests.reason, ": ")
        # What is sure and does not refute is held back: more paths leave it so.
        held = tests.suspected <= evidence.level and tests.refuted > SUSPECT
        more = Reason("finer levels would tell", Kind.FINER) if held else Reason("more of them would tell")
        return unlike.then(more), False
    if tests.blind <= 1.0:
        return Reason(), True
    doubt = Reason("{paths} paths do not show an error that the claim forbids", Kind.GUARD, paths)
    if not isfinite(tests.blind):
        return doubt.then("nor would more", ", "), True
    needed = tests.blind * evidence.paths
    return doubt.then(_ask_for_paths("about {paths} would", needed)), _beyond_budget(evidence, needed)


def _beyond_budget(evidence: Evidence, needed: float) -> bool:
    """Tell whether half of all paths say that all are too few: the last look, as long as all others, is saved."""
    most = evidence.settings.paths
    return most <= 2 * evidence.paths < 2 * most < 2 * needed


def _ask_for_paths(text: str, paths: float) -> Reason:
    rounded = f"{paths:.1g}" if paths >= 1e6 else str(int(float(f"{paths:.2g}")))
    return Reason(text, Kind.MORE_PATHS, {"paths": rounded})


def order_tests(claim: Claim, order: Estimate, evidence: Evidence, bias: float = 0.0) -> PathTests:
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

    Returns
    -------
    PathTests
    """
    if claim.value == ROUND_OFF:
        return PathTests(1.0, 0.0, Reason("claimed exact, and not so to round-off"))
    if isinstance(claim.value, str):
        return PathTests.none(unknown_value(claim))
    bound = claim.value - claim.margin
    low, high = order.interval(evidence.settings.confidence, bias)
    if not (isfinite(low) and isfinite(high)):
        return PathTests.none("no finite interval")
    growth, half = order.growth_to_decide(bound, evidence.level, bias), 0.5 * (high - low)
    reason = order_in(order.value, low, high, claim)
    above = order.p_above(bound, bias)
    if half > claim.margin and above <= evidence.level:
        above, growth = 1.0, max(growth, (half / claim.margin) ** 2 if bias < claim.margin else inf)
    return PathTests(above, order.p_below(bound, bias), reason, growth)


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
        return PathTests.none(f"intervals are calibrated from {CALIBRATED_PATHS} paths on", CALIBRATED_PATHS / paths)
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


def unlike(claim: Claim, slope: Estimate, corrected: Estimate, bias: float = 0.0) -> float:
    """Return the p-value of the hypothesis that errors look like a claimed order.

    They do not where the slope is below claim - margin; nor where it is nearer to that than to the claim, unless
    what it tends to with a further term of the expansion is not.

    Parameters
    ----------
    claim : Claim
        Of an order.
    slope, corrected : Estimate
        On the finest levels; with a further term.
    bias : float
        By how much the true slope may be larger than it is found.
    """
    if isinstance(claim.value, str):
        return 1.0
    middle = claim.value - 0.5 * claim.margin
    nearer = max(slope.p_below(middle, bias), corrected.p_below(middle, bias))
    return min(slope.p_below(claim.value - claim.margin, bias), nearer)


def hold_back(
    tests: PathTests, evidence: Evidence, levels: Array, coarse: str = "", growth: float = inf
) -> PathTests:
    """Refute nothing by levels that do not resolve the problem's fastest time; what they show stays suspicious.

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
    finest = min(evidence.step_sizes[level] for level in levels)
    why = why_unresolved(evidence.view, finest) or _beside_lost(evidence, levels) or coarse
    if not why or tests.against == 1.0:
        return tests
    return tests.held(why, growth=growth if tests.against <= SUSPECT else tests.growth)


def _beside_lost(evidence: Evidence, levels: Array) -> str:
    """Return that paths are lost on steps hardly longer than those that are left; empty if it is not so.

    Paths that all but explode carry the errors there, and an order shows on steps that keep clear of them.
    """
    lost = evidence.health.sums["lost"][: levels[0]]
    if len(levels) >= FITTED or not lost.any():
        return ""
    return f"{at_levels('paths are lost', lost > 0)}, and {len(levels)} are left; add finer levels"


def order_in(order: float, low: float, high: float, claim: Claim) -> Reason:
    """Return an order with its interval, beside what is claimed.

    Parameters
    ----------
    order, low, high : float
        Estimate and ends of its interval.
    claim : Claim
    """
    text = "order {order:.3f}, at least {low:.3f} and at most {high:.3f}; claimed {claimed}"
    return Reason(text, Kind.ORDER, {"order": order, "low": low, "high": high, "claimed": claim.value})


def withhold_in_doubt(findings: list[Finding]) -> list[Finding]:
    """Verify no quantity of a scheme that is known to tend to the wrong limit in another one."""
    wrong = [f.quantity for f in findings if f.verdict is Verdict.REFUTED and f.reason.has(Kind.WRONG_LIMIT)]
    if not wrong:
        return findings
    doubt = f"not confirmed: {Kind.WRONG_LIMIT} in {', '.join(wrong)}"
    return [f.withhold(doubt) if f.verdict is Verdict.VERIFIED else f for f in findings]


def no_fit(evidence: Evidence, covered: Coverage, left_out: Reason) -> Opinion:
    """Return the opinion on a quantity that has too few levels for a slope, and why they were left out.

    Parameters
    ----------
    evidence : Evidence
    covered : Coverage
    left_out : Reason
        Why levels were left out.
    """
    verdict = Verdict.INCONCLUSIVE if covered.claim else Verdict.OUT_OF_SCOPE
    if evidence.health.sums["lost"][-1] > 0:
        verdict = Verdict.DIVERGED
    return Opinion(verdict, Reason(f"fewer than {FEWEST} levels can be fitted: ").then(left_out, ""))
