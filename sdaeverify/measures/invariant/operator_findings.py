"""Findings on stationary means from the transition operator (T2): no sampling error, so that local orders decide."""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from ...contracts.measure import Evidence, Finding, LevelFinding, Verdict
from ...contracts.scheme import Claim
from ...forms import Problem
from ...forms.truths import InvariantMean
from ...probe.operator.functional_orders import (
    FunctionalOrder,
    bounded,
    error_floors,
    functional_orders,
    obstacle,
)
from ...probe.operator.transition_errors import TransitionErrors, invariant_observables
from ..judge import Opinion, claim_for
from .bias import bias_bound, known_bias, with_bias

METHOD = "stationary law of the transition operator (T2)"
# How far an order may be below the claimed one.
TOLERANCE = 0.15


def usable(record: TransitionErrors) -> bool:
    """Tell whether the scheme stays on the chart."""
    return not obstacle(record)


def operator_findings(evidence: Evidence, record: TransitionErrors) -> list[Finding]:
    """Return a finding for each observable whose exact mean is known."""
    by_name = _orders(evidence.view, record)
    columns = dict(zip(by_name, zip(record.errors.T, error_floors(record).T, strict=True), strict=True))
    found = []
    for name in (truth.observable for truth in evidence.view.truths if isinstance(truth, InvariantMean)):
        found.append(_finding(evidence, name, by_name.get(name)))
        bound = bias_bound(found[-1].claim)
        if bound is not None and name in by_name:
            found[-1] = with_bias(found[-1], known_bias(bound, record.h, *columns[name], by_name[name]))
    return found


def is_settled(evidence: Evidence, record: TransitionErrors) -> bool:
    """Tell whether finer steps would tell no more: all that is claimed is verified, or fixed by a symmetry."""
    fixed = {name for name, told in _orders(evidence.view, record).items() if told.fixed}
    claimed = {found.quantity: found.verdict for found in operator_findings(evidence, record) if found.claim}
    return all(verdict is Verdict.VERIFIED for name, verdict in claimed.items() if name not in fixed)


def operator_levels(evidence: Evidence, record: TransitionErrors) -> Iterator[LevelFinding]:
    """Yield the error of each observable at each step size."""
    floors = error_floors(record)
    for index, name in enumerate(invariant_observables(evidence.view)):
        errors = record.errors[:, index]
        for level, h in enumerate(record.h):
            details = {
                "error_floor": float(floors[level, index]),
                "local_order": _local_order(record.h, errors, level),
            }
            yield LevelFinding(name, None, float(errors[level]), 0.0, details, float(h))


def _orders(view: Problem, record: TransitionErrors) -> dict[str, FunctionalOrder]:
    return dict(zip(invariant_observables(view), bounded(functional_orders(record), view), strict=True))


def _finding(evidence: Evidence, name: str, told: FunctionalOrder | None) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, "invariant", name)
    opinion = Opinion(Verdict.OUT_OF_SCOPE, no_claim) if claim is None else _opinion(claim, told)
    order = told or FunctionalOrder(np.nan, np.nan, np.nan)
    return Finding(
        quantity=name,
        verdict=opinion.verdict,
        reason=opinion.reason,
        claim=claim,
        estimate=order.order,
        low=order.low,
        high=order.high,
        method=METHOD,
        tier=2,
        details={"leading_coefficient": order.coefficient},
    )


def _opinion(claim: Claim, told: FunctionalOrder | None) -> Opinion:
    if told is None:
        return Opinion(Verdict.NOT_APPLICABLE, "it is no function of the problem's chart")
    if isinstance(claim.value, str):
        return Opinion(Verdict.INCONCLUSIVE, f"this measure does not know what {claim.value!r} means")
    return _of_order(claim.value, told)


def _of_order(order: float, found: FunctionalOrder) -> Opinion:
    if not found.resolved:
        return Opinion(Verdict.INCONCLUSIVE, found.note)
    if not found.informative:
        return Opinion(Verdict.NOT_APPLICABLE, f"uninformative: {found.note}")
    bound, reason = order - TOLERANCE, f"order {found.order:.3f} as h tends to 0, claimed {order}"
    reason = f"{reason}; {found.note}" if found.note else reason
    if found.low >= bound:
        return Opinion(Verdict.VERIFIED, reason)
    if found.high < bound:
        return Opinion(Verdict.REFUTED, found.note if found.order == 0.0 else reason)
    return Opinion(Verdict.INCONCLUSIVE, f"{reason}; it is at least {found.low:.3f} and at most {found.high:.3f}")


def _local_order(h: Array, errors: Array, level: int) -> float:
    if level == 0 or not errors[level - 1 : level + 1].all():
        return float("nan")
    return float(np.log(abs(errors[level - 1] / errors[level])) / np.log(h[level - 1] / h[level]))
