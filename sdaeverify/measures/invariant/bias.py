"""Whether a stationary mean is right within a bound at every step size: for schemes whose bias has no order.

A claim of an order asks how a bias falls. One that there is none beyond b is verified where the interval of the bias
lies inside [-b, b] at each step size that is probed, and refuted where one lies outside.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.measure import Evidence, Finding, Verdict
from ...contracts.scheme import UNBIASED, Claim
from ...numerics.statistics import GROUPS
from ...probe.operator.functional_orders import ABOVE_FLOOR, FunctionalOrder
from ..outweighed import growth, outweighs
from .chain_order import Sample


class BiasOpinion(NamedTuple):
    """What is said of a claimed bound.

    Attributes
    ----------
    verdict : Verdict
    reason : str
    estimate, low, high : float
        The bias at the step size where it is largest, with its interval.
    p_verified, p_refuted : float
        For all looks together; NaN without sampling.
    growth : float
        By which factor the number of chains must grow to decide; infinite where more of them cannot.
    """

    verdict: Verdict
    reason: str
    estimate: float
    low: float
    high: float
    p_verified: float = float("nan")
    p_refuted: float = float("nan")
    growth: float = float("inf")


def bias_bound(claim: Claim | None) -> float | None:
    """Return the bound within which a mean is claimed to be unbiased, or None where it is not."""
    return claim.bound if claim is not None and claim.value == UNBIASED else None


def with_bias(found: Finding, said: BiasOpinion) -> Finding:
    """Return a finding with what is said of a claimed bound, in place of an order."""
    fields = {name: getattr(said, name) for name in Finding.__dataclass_fields__ if name in said._fields}
    return replace(found, **fields, details={**found.details, "class": "bias"})


def known_bias(bound: float, h: Array, errors: Array, floors: Array, told: FunctionalOrder) -> BiasOpinion:
    """Return what errors without sampling say of a bound.

    Parameters
    ----------
    bound : float
    h, errors, floors : ndarray, shape (H,)
        Step sizes, biases and how far these can be off.
    told : FunctionalOrder
        What the same errors say about an order.

    Returns
    -------
    BiasOpinion
    """
    off = ABOVE_FLOOR * floors
    known = np.isfinite(errors + off)
    most = np.where(known, np.abs(errors) + off, np.inf)
    at = int(np.argmax(most))
    if ((np.abs(errors) - off)[known] > bound).any():
        verdict, at = Verdict.REFUTED, int(np.argmax(np.where(known, np.abs(errors) - off, -np.inf)))
    else:
        verdict = Verdict.VERIFIED if (most <= bound).all() else Verdict.INCONCLUSIVE
    reason = _words(errors[at], off[at], h[at], h, bound)
    if told.fixed:
        verdict, reason = Verdict.NOT_APPLICABLE, f"uninformative: {told.note}"
    return BiasOpinion(verdict, reason, errors[at], errors[at] - off[at], errors[at] + off[at])


def sampled_bias(bound: float, looks: Sequence[Sample], planned: float, evidence: Evidence) -> BiasOpinion:
    """Return what chains say of a bound, each p-value being shared among the planned looks.

    That the bias is within the bound at all step sizes is tested at each of them by itself; that it is beyond at one
    of them is a test at each, with its level shared.

    Parameters
    ----------
    bound : float
    looks : sequence of Sample
    planned : float
        Number of looks that were planned.
    evidence : Evidence
        For the confidence of intervals and the level of a test.

    Returns
    -------
    BiasOpinion
    """
    within, beyond = zip(*(_p_values(bound, sample.errors) for sample in looks), strict=True)
    verified, refuted = (min(1.0, planned * min(found)) for found in (within, beyond))
    errors, h = looks[-1].errors, looks[-1].h
    mean, se = errors.mean(axis=0), errors.std(axis=0, ddof=1) / np.sqrt(GROUPS)
    half = scipy.special.stdtrit(GROUPS - 1, 0.5 + 0.5 * evidence.settings.confidence) * se
    at = int(np.argmax(np.abs(mean)))
    verdict = Verdict.INCONCLUSIVE
    if refuted <= evidence.level:
        verdict = Verdict.REFUTED
    elif verified <= evidence.level:
        verdict = Verdict.VERIFIED
    reason = _words(mean[at], half[at], h[at], h, bound)
    more = growth(min(within[-1], beyond[-1]), evidence.level / planned)
    ends = float(mean[at]), float(mean[at] - half[at]), float(mean[at] + half[at])
    return BiasOpinion(verdict, reason, *ends, verified, refuted, more)


def _p_values(bound: float, errors: Array) -> tuple[float, float]:
    granted = np.full_like(errors, bound)
    within, beyond = outweighs(granted, errors), outweighs(errors, granted)
    return float(within.max()), min(1.0, len(beyond) * float(beyond.min()))


def _words(bias: float, off: float, at: float, h: Array, bound: float) -> str:
    where = f"at h = {at:.3g}, where it is largest of {len(h)} step sizes from {h.min():.3g} to {h.max():.3g}"
    return f"bias {bias:.2g}, known to {off:.1g}, {where}; claimed within {bound:g}"
