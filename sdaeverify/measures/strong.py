"""Strong order: pathwise errors at T and as maximum over the coarsest grid times.

y_l = (1/p) log2 mean e_l^p against log2 h_l, p = 1 for the verdict, 1/2 and 2 beside it; the slope on the finest
four levels with a delete-a-group jackknife interval, widened by a bound of the reference's bias.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..forms import Problem
from ..hookspecs import hookimpl
from ..measure import Evidence, Finding, Judgement, LevelFinding, Measure, Verdict
from ..scheme import Claim
from ..settings import Settings
from ..statistics import Estimate, corrected_slope_weights
from ..truths import Pathwise
from ..verdicts import FEWEST, FITTED, Opinion, at_levels, claim_for, judge_order, sound_levels, unfitted, with_sample
from ._errors import AT_T, ErrorObserver
from ._quantity import Quantity, quantities_of
from ._reference_bias import Bias, reference_bias

WRONG = "wrong limit"
# A wrong limit shows as errors that stop falling while successive differences go on.
WRONG_LIMIT, RIGHT_LIMIT = -0.05, -0.15
# Steps too coarse for the problem show as local orders that grow by more than this from one level to the next.
RISING = 0.05


class Strong(Measure):
    """Strong order of convergence for each named component and the full state."""

    name: ClassVar[str] = "strong"

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> ErrorObserver:
        """Return the notebook for one block."""
        return ErrorObserver(parts, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each component at grid times and at T, and their levels."""
        quantities = list(quantities_of(evidence))
        findings = [_finding(evidence, quantity) for quantity in quantities]
        findings = _doubted(findings)
        findings += _unknown(evidence, {quantity.name for quantity in quantities})
        return Judgement(
            tuple(findings), tuple(row for quantity in quantities for row in _levels(evidence, quantity))
        )


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Strong()]


def _usable(evidence: Evidence, quantity: Quantity) -> tuple[Array, str]:
    """Return the levels that can be fitted, and why others are left out."""
    sound, remarks = sound_levels(evidence.health.sums)
    # Measured rounding stays below 2 eps sqrt(N) of the state's size; 30 times that leaves the fit alone.
    rounding = quantity.means() <= 60.0 * quantity.rounding(np.array(evidence.settings.steps))
    if rounding.any():
        remarks.append(at_levels("rounding", rounding))
    return sound[~rounding[sound]], "; ".join(remarks)


def _is_exact(evidence: Evidence, quantity: Quantity) -> bool:
    # A scheme that is its own reference may do nothing at all, and agree with itself.
    health, rounding = evidence.health.sums, quantity.rounding(np.array(evidence.settings.steps))
    if evidence.problem.pathwise is None or health["failed"].any() or health["truncated"].any():
        return False
    return bool(np.all(quantity.means() <= 64.0 * rounding))


def _exact_finding(quantity: Quantity, steps: int, claim: Claim | None) -> Finding:
    reason, verdict = "exact to round-off at every level", Verdict.VERIFIED
    if quantity.moved < 1e3 * 64.0 * quantity.rounding(np.array(steps)):
        # Who stands still is exact on a solution that does not move.
        reason, verdict = "the solution does not move beyond rounding", Verdict.INCONCLUSIVE
    if claim is None:
        verdict = Verdict.OUT_OF_SCOPE
    return Finding(quantity=quantity.name, verdict=verdict, reason=reason, claim=claim, method="paths")


def _doubted(findings: list[Finding]) -> list[Finding]:
    """Verify no quantity of a scheme that is known to tend to the wrong limit in another one."""
    wrong = [f.quantity for f in findings if f.verdict is Verdict.REFUTED and f.reason.startswith(WRONG)]
    if not wrong:
        return findings
    doubt = f"not confirmed: {WRONG} in {', '.join(wrong)}"
    return [
        replace(f, verdict=Verdict.INCONCLUSIVE, reason=f"{doubt}; {f.reason}")
        if f.verdict is Verdict.VERIFIED
        else f
        for f in findings
    ]


def _unknown(evidence: Evidence, known: set[str]) -> Iterator[Finding]:
    view, paths = evidence.view, 1
    start = evidence.scheme.start(view, paths, evidence.step_sizes[0])
    for name in evidence.scheme.parts(view, start):
        if name not in known:
            claim, no_claim = claim_for(evidence.scheme, view.traits, Strong.name, name)
            verdict = Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE
            reason = f"the problem's truth does not know {name}" if claim else no_claim
            yield Finding(quantity=name, verdict=verdict, reason=reason, claim=claim)


def _finding(evidence: Evidence, quantity: Quantity) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, Strong.name, quantity.name.removesuffix(AT_T))
    if _is_exact(evidence, quantity):
        return _exact_finding(quantity, evidence.settings.steps[-1], claim)
    usable, left_out = _usable(evidence, quantity)
    levels = usable[-FITTED:]
    if len(levels) < FEWEST:
        return unfitted(evidence, quantity.name, claim, left_out)
    bias = reference_bias(evidence.problem.pathwise, quantity, levels, evidence.settings.confidence)
    slope = quantity.slope(levels)
    low, high = slope.interval(evidence.settings.confidence, bias.bound)
    opinion = _opinion(evidence, quantity, levels, claim, (low, high, bias))
    reason = "; ".join(text for text in (opinion.reason if claim else no_claim, left_out) if text)
    return Finding(
        quantity=quantity.name,
        claim=claim,
        estimate=slope.value,
        low=low,
        high=high,
        verdict=opinion.verdict,
        reason=reason,
        method=f"paths, {bias.reference}",
        details={
            **_details(evidence, quantity, levels, slope),
            **_asymptotic(quantity, usable, evidence.settings.confidence),
            "bias_bound": bias.bound,
        },
    )


def _opinion(
    evidence: Evidence,
    quantity: Quantity,
    levels: Array,
    claim: Claim | None,
    order: tuple[float, float, Bias],
) -> Opinion:
    low, high, bias = order
    if claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, "")
    if not np.isfinite([low, high]).all():
        return Opinion(Verdict.INCONCLUSIVE, f"no finite interval: {bias.reference} is too coarse or not finite")
    opinion = judge_order(claim, low, high)
    if (
        opinion.verdict is Verdict.REFUTED
        and quantity.rise(levels).interval(evidence.settings.confidence)[0] > RISING
    ):
        opinion = Opinion(
            Verdict.INCONCLUSIVE, f"{opinion.reason}, but it still rises with refinement; add finer levels"
        )
    if bias.knows_limit:
        contrast = quantity.contrast(levels).interval(evidence.settings.confidence, bias.bound)
        opinion = _with_limit(opinion, contrast, above=not isinstance(claim.value, str) and low > claim.value)
    elif opinion.verdict is Verdict.VERIFIED:
        opinion = Opinion(Verdict.INCONCLUSIVE, f"{opinion.reason}, but towards its own limit: no truth to compare")
    if opinion.verdict is not Verdict.INCONCLUSIVE and not _sharp(evidence.problem.pathwise, claim):
        opinion = Opinion(Verdict.INCONCLUSIVE, f"{bias.reference}: it should be half an order above the claim")
    heavy = quantity.tail(levels[0]).heavy or quantity.tail(levels[-1]).heavy
    return with_sample(opinion, quantity.paths, heavy=heavy)


def _sharp(truth: Pathwise | None, claim: Claim) -> bool:
    return truth is None or isinstance(claim.value, str) or truth.order >= claim.value + 0.5


def _with_limit(opinion: Opinion, contrast: tuple[float, float], *, above: bool) -> Opinion:
    low, high = contrast
    if high < WRONG_LIMIT and not above:
        return Opinion(Verdict.REFUTED, f"{WRONG}: errors level off (contrast at most {high:.3f})")
    if high < WRONG_LIMIT:
        # Errors a h + b h^2 look alike while b h matters, and cannot level off above the claimed order.
        return Opinion(Verdict.INCONCLUSIVE, f"limit not confirmed (contrast at most {high:.3f}); add finer levels")
    if opinion.verdict is Verdict.VERIFIED and not low > RIGHT_LIMIT:
        return Opinion(
            Verdict.INCONCLUSIVE, f"limit not confirmed (contrast at least {low:.3f}); add paths or levels"
        )
    return opinion


def _details(evidence: Evidence, quantity: Quantity, levels: Array, slope: Estimate) -> dict[str, object]:
    confidence = evidence.settings.confidence
    contrast = quantity.contrast(levels)
    finest, coarsest = quantity.tail(levels[-1]), quantity.tail(levels[0])
    return {
        "std_error": slope.se,
        "order_L1/2": quantity.slope(levels, 0).value,
        "order_L2": quantity.slope(levels, 2).value,
        "fitted_levels": len(levels),
        "contrast": contrast.value,
        "contrast_low": contrast.interval(confidence)[0],
        "contrast_high": contrast.interval(confidence)[1],
        "effective_share": min(finest.effective, coarsest.effective),
        "largest_share": max(finest.share, coarsest.share),
        "hill_index": min(finest.hill, coarsest.hill),
        "heavy_tails": finest.heavy or coarsest.heavy,
    }


def _asymptotic(quantity: Quantity, usable: Array, confidence: float) -> dict[str, object]:
    # y = a + p x + c h on all levels but the coarsest; what the coarsest would change is part of the interval.
    if len(usable) <= FITTED:
        return {"asymptotic_order": float("nan"), "asymptotic_half_width": float("nan")}
    x, finer = np.log2(quantity.h), usable[1:]
    order = quantity.linear(finer, corrected_slope_weights(x[finer]))
    gap = abs(order.value - quantity.linear(usable, corrected_slope_weights(x[usable])).value)
    half = order.interval(confidence)[1] - order.value + gap
    return {"asymptotic_order": order.value, "asymptotic_half_width": max(half, 0.05)}


def _levels(evidence: Evidence, quantity: Quantity) -> Iterator[LevelFinding]:
    fitted = set(_usable(evidence, quantity)[0][-FITTED:])
    half, one, two = (quantity.means(power) for power in range(3))
    for level in range(len(quantity.h)):
        spread = np.sqrt(max(two[level] - one[level] ** 2, 0.0) / quantity.paths)
        local: Any = Estimate(float("nan"), float("nan"))
        if level and one[level - 1 : level + 1].all():
            local = quantity.slope(np.array([level - 1, level]))
        details = {
            "estimate_L1/2": half[level] ** 2,
            "estimate_L2": np.sqrt(two[level]),
            "local_order": local.value,
            "local_order_std_error": local.se,
            "fitted": level in fitted,
        }
        yield LevelFinding(quantity.name, level, float(one[level]), float(spread), details)
