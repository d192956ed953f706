"""Findings on stationary means from the transition operator (T2): no sampling error, so that local orders decide.

An order that is reached says nothing of an error that stays as h tends to 0, as long as that is a small part of the
errors at the step sizes used. It is found by extrapolation: eliminating h^p, h^(p+1), ... one after the other leaves
the limit (Romberg), known to how far the last eliminations still changed it.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..measure import Evidence, Finding, LevelFinding, Verdict
from ..probe.functional_orders import FunctionalOrder, error_floors, functional_orders, obstacle
from ..probe.transition_errors import TransitionErrors, invariant_observables
from ..scheme import Claim
from ..truths import InvariantMean
from ..verdicts import Opinion, claim_for

METHOD = "stationary law of the transition operator (T2)"
# How far an order may be below the claimed one.
TOLERANCE = 0.15
# A limit is wrong where it is off by so many times what is known of it.
CLEAR = 10.0


def usable(record: TransitionErrors) -> bool:
    """Tell whether the scheme stays on the chart."""
    return not obstacle(record)


def limit(h: Array, errors: Array, floors: Array, order: float) -> tuple[float, float]:
    """Return the error extrapolated to h = 0, and a bound of what the extrapolation leaves open.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, each half of the one before.
    errors, floors : ndarray, shape (H,)
    order : float
        p of an error c_0 h^p + c_1 h^(p+1) + ..., in halves of 1 where it is no whole number.

    Returns
    -------
    tuple of float
    """
    step = 1.0 if float(order).is_integer() else 0.5
    table, blur, last = errors, floors, [errors[-1]]
    for column in range(len(h) - 1):
        ratio = (h[0] / h[1]) ** (order + step * column)
        table = (ratio * table[1:] - table[:-1]) / (ratio - 1.0)
        blur = (ratio * blur[1:] + blur[:-1]) / (ratio - 1.0)
        last.append(table[-1])
    return float(last[-1]), float(np.abs(np.diff(last[-3:])).max() + blur[-1])


def operator_findings(evidence: Evidence, record: TransitionErrors) -> list[Finding]:
    """Return a finding for each observable whose exact mean is known."""
    found = [
        _Told(*told) for told in zip(record.errors.T, error_floors(record).T, functional_orders(record), strict=True)
    ]
    by_name = dict(zip(invariant_observables(evidence.view), found, strict=True))
    names = [truth.observable for truth in evidence.view.truths if isinstance(truth, InvariantMean)]
    return [_finding(evidence, name, record.h, by_name.get(name)) for name in names]


class _Told(NamedTuple):
    # What the operator tells of one observable: errors and floors (H,), and the order.
    errors: Array
    floors: Array
    order: FunctionalOrder


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


def _finding(evidence: Evidence, name: str, h: Array, told: _Told | None) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, "invariant", name)
    opinion = Opinion(Verdict.OUT_OF_SCOPE, no_claim) if claim is None else _opinion(claim, h, told)
    order = told.order if told else FunctionalOrder(np.nan, np.nan, np.nan)
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


def _opinion(claim: Claim, h: Array, told: _Told | None) -> Opinion:
    if told is None:
        return Opinion(Verdict.NOT_APPLICABLE, "it is no function of the problem's chart")
    if isinstance(claim.value, str):
        return Opinion(Verdict.INCONCLUSIVE, f"this measure does not know what {claim.value!r} means")
    off, known = limit(h, told.errors, told.floors, claim.value)
    if abs(off) > CLEAR * known:
        return Opinion(Verdict.REFUTED, f"wrong limit: off by {off:.2g} as h tends to 0, known to {known:.1g}")
    return _of_order(claim.value, told.order)


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
        return Opinion(Verdict.REFUTED, reason)
    return Opinion(Verdict.INCONCLUSIVE, f"{reason}; it is at least {found.low:.3f} and at most {found.high:.3f}")


def _local_order(h: Array, errors: Array, level: int) -> float:
    if level == 0 or not errors[level - 1 : level + 1].all():
        return float("nan")
    return float(np.log(abs(errors[level - 1] / errors[level])) / np.log(h[level - 1] / h[level]))
