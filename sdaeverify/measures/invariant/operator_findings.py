"""Findings on stationary means from the transition operator (T2): no sampling error, so that local orders decide."""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from ...contracts.finding import Finding, Kind, LevelFinding, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
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
from ..judge import Coverage, coverage, finding, judge_claim
from .bias import bias_bound, bias_of_operator, with_bias

METHOD = "stationary law of the transition operator (T2)"
# How far an order may be below the claimed one.
TOLERANCE = 0.15
NO_ORDER = FunctionalOrder(np.nan, np.nan, np.nan)


def usable(record: TransitionErrors) -> bool:
    """Tell whether the scheme stays on the chart."""
    return not obstacle(record)


def operator_findings(evidence: Evidence, record: TransitionErrors) -> list[Finding]:
    """Return a finding for each observable whose exact mean is known."""
    orders = _orders(evidence.view, record)
    columns = dict(zip(orders, zip(record.errors.T, error_floors(record).T, strict=True), strict=True))
    found = []
    for name in (truth.observable for truth in evidence.view.truths if isinstance(truth, InvariantMean)):
        found.append(_finding(coverage(evidence, "invariant", name), orders.get(name)))
        bound = bias_bound(found[-1].claim)
        if bound is not None and name in orders:
            found[-1] = with_bias(found[-1], *bias_of_operator(bound, record.h, *columns[name], orders[name]))
    return found


def is_settled(evidence: Evidence, record: TransitionErrors) -> bool:
    """Tell whether finer steps would tell no more: all that is claimed is verified, or fixed by a symmetry."""
    fixed = {name for name, order in _orders(evidence.view, record).items() if order.fixed}
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


def _finding(covered: Coverage, known: FunctionalOrder | None) -> Finding:
    if covered.claim is not None and known is None:
        opinion = Opinion(Verdict.NOT_APPLICABLE, Reason("it is no function of the problem's chart"))
    else:
        opinion = judge_claim(covered, lambda claim: _opinion(float(claim.value), known or NO_ORDER))
    order = known or NO_ORDER
    return finding(
        covered,
        opinion._replace(tier=2),
        estimate=order.order,
        low=order.low,
        high=order.high,
        method=METHOD,
        details={"leading_coefficient": order.coefficient},
    )


def _opinion(claimed: float, found: FunctionalOrder) -> Opinion:
    if not found.resolved:
        return Opinion(Verdict.INCONCLUSIVE, Reason(found.note))
    if not found.informative:
        return Opinion(Verdict.NOT_APPLICABLE, Reason(f"uninformative: {found.note}"))
    bound, figures = claimed - TOLERANCE, {"order": found.order, "claimed": claimed}
    reason = Reason("order {order:.3f} as h tends to 0, claimed {claimed}", Kind.ORDER, figures).then(found.note)
    if found.low >= bound:
        return Opinion(Verdict.VERIFIED, reason)
    if found.high < bound:
        return Opinion(Verdict.REFUTED, Reason(found.note, Kind.WRONG_LIMIT) if found.order == 0.0 else reason)
    return Opinion(Verdict.INCONCLUSIVE, reason.then(f"it is at least {found.low:.3f} and at most {found.high:.3f}"))


def _local_order(h: Array, errors: Array, level: int) -> float:
    if level == 0 or not errors[level - 1 : level + 1].all():
        return float("nan")
    return float(np.log(abs(errors[level - 1] / errors[level])) / np.log(h[level - 1] / h[level]))
