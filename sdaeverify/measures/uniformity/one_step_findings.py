"""What the defects of one step say of a claim about its local weak error for all stiffness parameters.

Each first and second moment has an order of its own, the last one above rounding, and what it tends to. One that is
below the claim, less its margin, in both refutes it.
"""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from ...contracts.finding import Finding, Kind, LevelFinding, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim
from ...probe.local.orders import last_orders
from ...probe.stiffness.uniform_local import UniformDefects
from ..judge import Coverage, coverage, finding, is_order

MEASURE, ONE_STEP = "uniformity", "one step"
METHOD = "one step against two half steps, supremum over eps (T1)"
FEWEST = 3


def one_step_coverage(evidence: Evidence) -> Coverage:
    """Return what is claimed of one step; a claim about errors along paths is none."""
    covered = coverage(evidence, MEASURE, ONE_STEP)
    named = covered.claim is not None and ONE_STEP in covered.claim.quantities
    return covered if named else covered._replace(claim=None)


def one_step_finding(covered: Coverage, record: UniformDefects, names: list[str]) -> Finding:
    """Return the finding on the order of the local weak error, uniformly in eps.

    Parameters
    ----------
    covered : Coverage
        With a claim.
    record : UniformDefects
    names : list of str
        Of the moments.
    """
    assert covered.claim is not None
    found = [_orders(record, *pair) for pair in ((record.halves, record.floor), (record.euler, record.nearly))]
    order, ahead = (np.concatenate(parts) for parts in zip(*found, strict=True))
    against = [f"{name} against {what}" for what in ("two half steps", "Euler's step") for name in names]
    worst = int(np.where(np.isnan(order), -np.inf, np.fmax(order, ahead)).argmin())
    figures = {"order": order[worst], "functional": against[worst], "claimed": covered.claim.value}
    text = "local order {order:.3f} in {functional}; claimed {claimed}"
    verdict, remark = _verdict(covered.claim, record, order, ahead)
    joint = "; " if is_order(covered.claim) else ": "
    opinion = Opinion(verdict, Reason(text, Kind.ORDER, figures).then(remark, joint), 1)
    return finding(
        covered, opinion, estimate=float(order[worst]), method=METHOD, details={"functional": against[worst]}
    )


def one_step_levels(record: UniformDefects, names: list[str]) -> Iterator[LevelFinding]:
    """Yield the largest difference from two half steps of each moment at each step size."""
    for name, sizes, ratios in zip(names, record.halves, record.ratio, strict=True):
        for h, size, ratio in zip(record.h, sizes, ratios, strict=True):
            details = {"functional": name, "worst_eps": float(ratio * h)}
            yield LevelFinding(ONE_STEP, None, float(size), 0.0, details, float(h))


def _orders(record: UniformDefects, size: Array, floor: Array) -> tuple[Array, Array]:
    rooted = record.failed == 0.0
    if rooted.sum() < FEWEST:
        return np.full(len(size), np.nan), np.full(len(size), np.nan)
    found = last_orders(record.h[rooted], size[:, rooted], floor[:, rooted], np.ones(int(rooted.sum())))
    return found.order, found.ahead


def _verdict(claim: Claim, record: UniformDefects, order: Array, ahead: Array) -> tuple[Verdict, str]:
    """Return the verdict, and what is to be said beside the figures."""
    if isinstance(claim.value, str):
        return Verdict.INCONCLUSIVE, "this measure does not know what that means"
    bound = claim.value - claim.margin
    if np.any(np.maximum(order, ahead) < bound):
        return Verdict.REFUTED, ""
    if np.all(np.minimum(order, ahead) >= bound):
        return Verdict.VERIFIED, ""
    lost = int(np.sum(record.failed > 0.0))
    return Verdict.INCONCLUSIVE, f"steps without root at {lost} step sizes" if lost else "not settled"
