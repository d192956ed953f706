"""Three-valued verdicts on orders: a claim is verified, refuted, or the evidence does not decide."""

from collections.abc import Iterable, Mapping
from math import inf
from typing import NamedTuple

import numpy as np

from .arrays import Array, Mask
from .measure import Evidence, Finding, Verdict
from .scheme import Claim, Scheme

ROUND_OFF = "round-off"
# A slope is fitted on so many of the finest levels; fewer than FEWEST tell none.
FITTED = 4
FEWEST = 3
CALIBRATED_PATHS = 100
HEAVY_TAIL_PATHS = 800


class Opinion(NamedTuple):
    """A verdict with its reason."""

    verdict: Verdict
    reason: str


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


def judge_order(claim: Claim, low: float, high: float) -> Opinion:
    """Compare an interval of the order with a claimed least order.

    Verified needs the whole interval above value - margin and no wider than the margin on either side; refuted
    needs the whole interval below it.

    Parameters
    ----------
    claim : Claim
        One that claims exactness is refuted: whoever asks for an order has seen more than rounding.
    low, high : float
        Interval of the order at the run's confidence.

    Returns
    -------
    Opinion
    """
    if claim.value == ROUND_OFF:
        return Opinion(Verdict.REFUTED, "claimed exact, and not so to round-off")
    if isinstance(claim.value, str):
        return Opinion(Verdict.INCONCLUSIVE, f"this measure does not know what {claim.value!r} means")
    bound, half = claim.value - claim.margin, 0.5 * (high - low)
    if high < bound:
        return Opinion(Verdict.REFUTED, f"order at most {high:.3f}, claimed {claim.value} with margin {claim.margin}")
    if low > bound and half <= claim.margin:
        return Opinion(Verdict.VERIFIED, f"order at least {low:.3f}")
    if low > bound:
        return Opinion(Verdict.INCONCLUSIVE, f"interval of half width {half:.2f} is wider than the margin; add paths")
    return Opinion(
        Verdict.INCONCLUSIVE, f"interval [{low:.3f}, {high:.3f}] contains {bound:.3f}; add paths or levels"
    )


def with_sample(opinion: Opinion, paths: int, *, heavy: bool) -> Opinion:
    """Take a verdict back where the sample does not carry it: too small, or resting on a few paths."""
    if opinion.verdict not in {Verdict.VERIFIED, Verdict.REFUTED}:
        return opinion
    if paths < CALIBRATED_PATHS:
        return Opinion(Verdict.INCONCLUSIVE, f"intervals are calibrated from {CALIBRATED_PATHS} paths on")
    if opinion.verdict is Verdict.REFUTED and heavy and paths < HEAVY_TAIL_PATHS:
        return Opinion(Verdict.INCONCLUSIVE, f"heavy tails: at least {HEAVY_TAIL_PATHS} paths are needed to refute")
    return opinion


def sound_levels(health: Mapping[str, Array]) -> tuple[Array, list[str]]:
    """Return the levels finer than every one that went wrong, and what went wrong.

    An order is about h tending to 0: coarse levels may fail, but what fails on a finer level than another that
    does not is no matter of too coarse a step.

    Parameters
    ----------
    health : mapping of str to ndarray, shape (L,)
        Counts ``failed`` of paths and ``truncated`` of steps.

    Returns
    -------
    ndarray of int
    list of str
    """
    wrong = {"failed paths": health["failed"] > 0, "truncated steps": health["truncated"] > 0}
    bad = np.flatnonzero(np.any(list(wrong.values()), axis=0))
    first = int(bad[-1]) + 1 if len(bad) else 0
    remarks = [at_levels(name, levels) for name, levels in wrong.items() if levels.any()]
    return np.arange(first, len(health["failed"])), remarks


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
        return inf if claim.value == ROUND_OFF else 0.0
    return claim.value
