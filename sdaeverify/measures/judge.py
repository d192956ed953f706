"""Three-valued verdicts on orders: a claim is verified, refuted, or the evidence does not decide."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ..arrays import Array, Mask
from ..contracts.measure import Evidence, Finding, Verdict
from ..contracts.scheme import Claim, Scheme
from ..numerics.statistics import Estimate
from ..probe.local.orders import LocalOpinion
from ..probe.step.one_step import unresolved

ROUND_OFF = "round-off"
# How the reason of a refutation begins that concerns the scheme as a whole.
WRONG = "wrong limit"
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
SHALLOW = 0.001


class Opinion(NamedTuple):
    """A verdict with its reason."""

    verdict: Verdict
    reason: str


class Tests(NamedTuple):
    """What the paths say of a claim.

    Attributes
    ----------
    verified, refuted : float
        p-values of the two hypotheses which the verdicts reject; 1 where nothing can be rejected.
    reason : str
        The figures in words.
    growth : float
        By which factor the number of paths must grow to decide; infinite if more paths cannot.
    suspected : float
        What `refuted` would be if the sample could be relied on: it asks for more paths, and refutes nothing.
    blind : float
        By which factor the number of paths must grow until an error shows that is as large as the claim forbids; 1
        where it would show now, infinite if more paths do not help.
    """

    verified: float
    refuted: float
    reason: str
    growth: float = inf
    suspected: float = 1.0
    blind: float = 1.0

    @classmethod
    def none(cls, reason: str, growth: float = inf) -> "Tests":
        """Return tests that reject nothing, and why."""
        return cls(1.0, 1.0, reason, growth)


class Decision(NamedTuple):
    """A verdict as a `Finding` takes it; see there for the attributes."""

    verdict: Verdict
    reason: str
    tier: int
    settled: bool = True
    p_verified: float = nan
    p_refuted: float = nan


def decide(tests: Tests, evidence: Evidence) -> Decision:
    """Return the verdict of the paths alone."""
    found = Verdict.INCONCLUSIVE
    if tests.refuted <= evidence.level:
        found = Verdict.REFUTED
    elif tests.verified <= evidence.level:
        found = Verdict.VERIFIED
    more = found is Verdict.INCONCLUSIVE and np.isfinite(tests.growth)
    needed = f"; about {_round(tests.growth * evidence.paths)} paths would decide" if more else ""
    return Decision(found, tests.reason + needed, 3, not more, tests.verified, tests.refuted)


def guard(local: Opinion | LocalOpinion | None, tests: Tests, evidence: Evidence, tier: int = 1) -> Decision:
    """Return the verdict of a deterministic tier, guarded by the paths; theirs alone where it has none.

    What is refuted without sampling stays so. What is verified needs paths that could be compared, that would show an
    error which the claim forbids, and that do not refute it. Where they look as if they might, or are too few to show
    anything, more of them are asked for, and without more nothing is decided.
    """
    if local is None or local.verdict is Verdict.INCONCLUSIVE:
        return _unaided(local, tests, evidence)
    if local.verdict is Verdict.REFUTED:
        return Decision(local.verdict, local.reason, tier)
    if tests.refuted <= evidence.level:
        return Decision(Verdict.REFUTED, f"{tests.reason}, although {local.reason}", 3, p_refuted=tests.refuted)
    doubt, settled = _doubt(tests, evidence)
    if doubt:
        reason = f"{local.reason}, but {doubt}"
        return Decision(Verdict.INCONCLUSIVE, reason, 3, settled, p_refuted=tests.refuted)
    return Decision(Verdict.VERIFIED, local.reason, tier, p_refuted=tests.refuted)


def _doubt(tests: Tests, evidence: Evidence) -> tuple[str, bool]:
    """Return why paths that refute nothing are no guard, or an empty string, and whether more of them do not help."""
    if evidence.paths < CALIBRATED_PATHS:
        return f"{evidence.paths} paths are too few to guard it", True
    if min(tests.refuted, tests.suspected) <= 1.0 - evidence.settings.confidence:
        return f"the paths do not look like it: {tests.reason}; more of them would tell", False
    if tests.blind <= 1.0:
        return "", True
    helps = bool(np.isfinite(tests.blind))
    more = f"; about {_round(tests.blind * evidence.paths)} would" if helps else ", nor would more"
    return f"{evidence.paths} paths do not show an error that the claim forbids{more}", not helps


def _unaided(local: Opinion | LocalOpinion | None, tests: Tests, evidence: Evidence) -> Decision:
    decision = decide(tests, evidence)
    return decision if local is None else decision._replace(reason=f"{decision.reason}; {local.reason}")


def _round(paths: float) -> str:
    return f"{paths:.1g}" if paths >= 1e6 else str(int(float(f"{paths:.2g}")))


def claim_for(scheme: Scheme, traits: Iterable[str], measure: str, quantity: str) -> tuple[Claim | None, str]:
    """Return the strongest claim that covers a quantity on a problem with these traits.

    Parameters
    ----------
    scheme : Scheme
    traits : iterable of str
        Of the problem as the scheme sees it.
    measure, quantity : str

    Returns
    -------
    Claim or None
    str
        Why there is none; empty if there is one.
    """
    covering = [claim for claim in scheme.promises if claim.covers(measure, quantity)]
    in_scope = [claim for claim in covering if claim.when <= set(traits)]
    if in_scope:
        return max(in_scope, key=_strength), ""
    if not covering:
        return None, f"{scheme.name} claims nothing about {quantity}"
    missing = sorted(set().union(*(claim.when for claim in covering)) - set(traits))
    return None, f"claimed only for problems with {', '.join(missing)}"


def order_tests(claim: Claim, order: Estimate, evidence: Evidence, bias: float = 0.0) -> Tests:
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
    Tests
    """
    if claim.value == ROUND_OFF:
        return Tests(1.0, 0.0, "claimed exact, and not so to round-off")
    if isinstance(claim.value, str):
        return Tests.none(f"this measure does not know what {claim.value!r} means")
    bound = claim.value - claim.margin
    low, high = order.interval(evidence.settings.confidence, bias)
    if not np.isfinite([low, high]).all():
        return Tests.none("no finite interval")
    growth, half = order.growth_to_decide(bound, evidence.level, bias), 0.5 * (high - low)
    reason = f"order {order.value:.3f}, at least {low:.3f} and at most {high:.3f}; claimed {claim.value}"
    above = order.p_above(bound, bias)
    if half > claim.margin and above <= evidence.level:
        above, growth = 1.0, max(growth, (half / claim.margin) ** 2 if bias < claim.margin else inf)
    return Tests(above, order.p_below(bound, bias), reason, growth)


def with_sample(tests: Tests, paths: int, *, heavy: bool) -> Tests:
    """Reject nothing at levels for which the sample is too small, or too much on few paths, to be calibrated."""
    if paths < CALIBRATED_PATHS:
        return Tests.none(f"intervals are calibrated from {CALIBRATED_PATHS} paths on", CALIBRATED_PATHS / paths)
    if paths >= DEEP_PATHS:
        return tests
    growth = max(tests.growth, DEEP_PATHS / paths) if np.isfinite(tests.growth) else inf
    refuted = 1.0 if heavy else max(tests.refuted, SHALLOW)
    return Tests(max(tests.verified, SHALLOW), refuted, tests.reason, growth, tests.refuted)


def held_back(tests: Tests, evidence: Evidence, levels: Array, coarse: str = "", growth: float = inf) -> Tests:
    """Refute nothing by levels that do not resolve the problem's fastest time; what they show stays suspicious.

    Nor by levels that look too coarse for another reason, which so many times as many paths would make sure of.
    """
    why = unresolved(evidence.view, min(evidence.step_sizes[level] for level in levels)) or coarse
    suspected, growth = min(tests.refuted, tests.suspected), growth if coarse else tests.growth
    if not why or suspected == 1.0:
        return tests
    return tests._replace(refuted=1.0, suspected=suspected, growth=growth, reason=f"{tests.reason}; {why}")


def doubted(findings: list[Finding]) -> list[Finding]:
    """Verify no quantity of a scheme that is known to tend to the wrong limit in another one."""
    wrong = [f.quantity for f in findings if f.verdict is Verdict.REFUTED and f.reason.startswith(WRONG)]
    if not wrong:
        return findings
    doubt = f"not confirmed: {WRONG} in {', '.join(wrong)}"
    return [
        replace(f, verdict=Verdict.INCONCLUSIVE, reason=f"{doubt}; {f.reason}", p_verified=1.0)
        if f.verdict is Verdict.VERIFIED
        else f
        for f in findings
    ]


def sound_levels(health: Mapping[str, Array]) -> tuple[Array, list[str]]:
    """Return the levels finer than every one that went wrong, and what went wrong.

    An order is about h tending to 0: coarse levels may fail, but what fails on a finer level than another that
    does not is no matter of too coarse a step.

    Parameters
    ----------
    health : mapping of str to ndarray, shape (L,)
        Counts ``failed`` of paths and ``truncated`` of steps; ``singular`` with ``singular_time``, if the problem may
        lose its root.

    Returns
    -------
    ndarray of int
    list of str
    """
    wrong = {"failed paths": health["failed"] > 0, "truncated steps": health["truncated"] > 0}
    bad = np.flatnonzero(np.any(list(wrong.values()), axis=0))
    first = int(bad[-1]) + 1 if len(bad) else 0
    remarks = [at_levels(name, levels) for name, levels in wrong.items() if levels.any()]
    if text := lost_index(health):
        remarks.append(text)
    return np.arange(first, len(health["failed"])), remarks


def lost_index(health: Mapping[str, Array]) -> str:
    """Return where the problem itself loses its root, at the finest level where it does, or an empty string."""
    if "singular" not in health or not (count := health["singular"]).any():
        return ""
    level = int(np.flatnonzero(count)[-1])
    time = health["singular_time"][level] / count[level]
    return f"du/dy is singular on {count[level]:.0f} paths, at t = {time:.3g} in the mean: there the solution ends"


def at_levels(what: str, levels: Mask) -> str:
    """Return at how many levels something happened."""
    count = int(levels.sum())
    return f"{what} at {count} level{'' if count == 1 else 's'}"


def unfitted(evidence: Evidence, quantity: str, claim: Claim | None, left_out: str) -> Finding:
    """Return the finding on a quantity that has too few levels for a slope, and why they were left out."""
    if evidence.health.sums["lost"][-1] > 0:
        verdict = Verdict.DIVERGED
    else:
        verdict = Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE
    reason = f"fewer than {FEWEST} levels can be fitted: {left_out}"
    return Finding(quantity=quantity, verdict=verdict, reason=reason, claim=claim, method="paths")


def _strength(claim: Claim) -> float:
    if isinstance(claim.value, str):
        return inf if claim.value == ROUND_OFF else -(claim.bound or 0.0)
    return claim.value
