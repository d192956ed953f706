"""What becomes of a claim of uniform convergence: a component's findings on the grid and in continuous time."""

from collections.abc import Mapping
from typing import NamedTuple

from ...contracts.measure import Evidence, Finding, Verdict
from ...contracts.scheme import Claim
from ...probe.local.orders import LocalOpinion
from ..judge import FEWEST, FITTED, Decision, Tests, claim_for, decide, unfitted
from ..path_errors.order import EXACT, STILL, Fit, fit, is_exact, stands_still
from ..path_errors.quantity import Quantity
from .convergence import Grid, continuous_tests, finest_as_reference, grid_tests, levels_for, limit_test

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
