"""Bounds on the bias of stationary means at every step size, for schemes whose bias has no order.

A claim of an order is about the decrease of a bias. A claim that the bias is at most b is verified if the interval of
the bias lies inside [-b, b] at each step size that is probed, and refuted if one interval lies outside.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import UNBIASED, Bound
from ...contracts.finding import Finding, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...forms.truths import InvariantMean
from ...numerics.outweighed import outweighs, sample_growth
from ...probe.balance import Balance, say_imbalance
from ...probe.operator.functional_orders import ABOVE_FLOOR, FunctionalOrder
from ...probe.step.states import reached_states
from ...verdicts.path_tests import why_vacuous
from ...verdicts.rules import withhold
from .chain_order import BiasSample


class StationaryBias(NamedTuple):
    """The bias at the step size where it is largest, with its interval.

    Attributes
    ----------
    estimate, low, high : float
    growth : float
        Factor by which the number of chains must grow to decide; infinite if more chains cannot decide.
    """

    estimate: float
    low: float
    high: float
    growth: float = float("inf")


BALANCE = Method("detailed balance", 1)
# Theorem: detailed balance leaves the law invariant, Hastings (1970).
NO_BIAS = StationaryBias(0.0, 0.0, 0.0)


def bias_bound(claim: Claim | None) -> float | None:
    """Return the bound of a claim that a mean is unbiased, or None for other claims."""
    value = claim and claim.value
    return value.most if isinstance(value, Bound) and value.text == UNBIASED else None


def withhold_vacuous(found: Finding, evidence: Evidence) -> Finding:
    """Return a finding, not verified if the claimed bound is at least the size of the observable."""
    bound = bias_bound(found.claim)
    if bound is None or found.verdict is not Verdict.VERIFIED:
        return found
    vacuous = why_vacuous(bound, _spread(evidence, found.quantity))
    return withhold(found, vacuous) if vacuous else found


def _spread(evidence: Evidence, name: str) -> float:
    """Return the root mean square distance of an observable from its exact mean, at states that solutions reach.

    NaN if there is no equation of the states or no exact mean.
    """
    view = evidence.view
    truths = (truth for truth in view.truths if isinstance(truth, InvariantMean))
    equation, known = view.equation(), [truth.value for truth in truths if truth.observable == name]
    if equation is None or not known:
        return np.nan
    x = reached_states(view, equation).points
    value = view.observe(name, view.horizon, equation.parts(x))
    return np.nan if value is None else float(np.sqrt(np.mean((value - known[0]) ** 2)))


def with_bias(found: Finding, bias: StationaryBias, opinion: Opinion) -> Finding:
    """Return a finding with the opinion on a claimed bound in place of that on an order.

    Parameters
    ----------
    found : Finding
        Provides all other fields.
    bias : StationaryBias
        Estimate and interval, in the observable's unit.
    opinion : Opinion
        On the claimed bound.
    """
    return replace(
        found,
        verdict=opinion.verdict,
        reason=opinion.reason,
        p_verified=opinion.p_verified,
        p_refuted=opinion.p_refuted,
        estimate=bias.estimate,
        low=bias.low,
        high=bias.high,
        value_of="bias",
        details={**found.details, "class": "bias"},
    )


def bias_of_operator(
    bound: float, h: Array, errors: Array, floors: Array, order: FunctionalOrder
) -> tuple[StationaryBias, Opinion]:
    """Judge a bound by errors that have no sampling error.

    Parameters
    ----------
    bound : float
    h, errors, floors : ndarray, shape (H,)
        Step sizes, biases and their numerical errors.
    order : FunctionalOrder
        Order estimated from the same errors.

    Returns
    -------
    StationaryBias
    Opinion
    """
    off = ABOVE_FLOOR * floors
    known = np.isfinite(errors + off)
    most = np.where(known, np.abs(errors) + off, np.inf)
    at = int(np.argmax(most))
    if ((np.abs(errors) - off)[known] > bound).any():
        verdict, at = Verdict.REFUTED, int(np.argmax(np.where(known, np.abs(errors) - off, -np.inf)))
    else:
        verdict = Verdict.VERIFIED if (most <= bound).all() else Verdict.INCONCLUSIVE
    reason = _figures(errors[at], off[at], h[at], h, bound)
    if order.fixed:
        verdict, reason = Verdict.NOT_APPLICABLE, Reason(f"not informative: {order.note}")
    return StationaryBias(errors[at], errors[at] - off[at], errors[at] + off[at]), Opinion(verdict, reason)


def bias_of_chains(
    bound: float, looks: Sequence[BiasSample], planned: float, evidence: Evidence
) -> tuple[StationaryBias, Opinion]:
    """Judge a bound by chains, with each p-value multiplied by the number of planned looks.

    The hypothesis that the bias exceeds the bound at some step size is tested at each of them separately. The
    hypothesis that it is within the bound at all of them is tested at each, with the level shared among them.

    Parameters
    ----------
    bound : float
    looks : sequence of BiasSample
    planned : float
        Number of looks that were planned.
    evidence : Evidence
        Provides the confidence of intervals and the level of a test.

    Returns
    -------
    StationaryBias
    Opinion
    """
    within, beyond = zip(*(_p_values(bound, sample.errors) for sample in looks), strict=True)
    verified, refuted = (min(1.0, planned * min(found)) for found in (within, beyond))
    errors, h = looks[-1].errors, looks[-1].h
    mean, half = looks[-1].known_errors(evidence.settings.confidence)
    at = int(np.argmax(np.abs(mean)))
    verdict = Verdict.INCONCLUSIVE
    if refuted <= evidence.level:
        verdict = Verdict.REFUTED
    elif verified <= evidence.level:
        verdict = Verdict.VERIFIED
    reason = _figures(mean[at], half[at], h[at], h, bound)
    more = sample_growth(min(within[-1], beyond[-1]), evidence.level / planned, len(errors))
    bias = StationaryBias(float(mean[at]), float(mean[at] - half[at]), float(mean[at] + half[at]), more)
    return bias, Opinion(verdict, reason, p_verified=verified, p_refuted=refuted)


def _p_values(bound: float, errors: Array) -> tuple[float, float]:
    granted = np.full_like(errors, bound)
    within, beyond = outweighs(granted, errors), outweighs(errors, granted)
    return float(within.max()), min(1.0, len(beyond) * float(beyond.min()))


def _figures(bias: float, off: float, at: float, h: Array, bound: float) -> Reason:
    where = f"at h = {at:.3g}, one of {len(h)} step sizes from {h.min():.3g} to {h.max():.3g}"
    text = "largest bias {bias:.2g} +- {off:.1g} {where}; claimed within {bound:g}"
    return Reason(text, numbers={"bias": bias, "off": off, "where": where, "bound": bound})


def judge_balance(findings: Sequence[Finding], found: Balance | None) -> Sequence[Finding]:
    """Return findings on bounds of a bias that detailed balance verifies, or with the reason why it fails.

    Its failure does not refute, because steps may leave a law invariant without it.

    Parameters
    ----------
    findings : sequence of Finding
    found : Balance or None
        None if detailed balance was not probed.
    """
    if found is None or not found.seen.any():
        return findings
    holds = "detailed balance holds for {pairs} pairs of states at {sizes} step sizes"
    figures = {"pairs": int(found.seen.sum()), "sizes": len(found.density)}
    opinion = Opinion(Verdict.VERIFIED, Reason(holds, numbers=figures), tier=1)
    if not found.holds:
        fails = say_imbalance(found)
        open_ = (bias_bound(each.claim) is not None and each.verdict is not Verdict.VERIFIED for each in findings)
        together = zip(findings, open_, strict=True)
        return [replace(each, reason=each.reason.then(fails)) if left else each for each, left in together]
    unbiased = (replace(with_bias(each, NO_BIAS, opinion), tier=1, method=BALANCE) for each in findings)
    return [each if bias_bound(each.claim) is None else new for each, new in zip(findings, unbiased, strict=True)]
