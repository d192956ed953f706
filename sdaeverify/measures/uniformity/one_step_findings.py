"""What the defects of one step say of a claim about its local weak error for all stiffness parameters.

Each first and second moment has an order of its own, the last one above rounding, and what it tends to. One that is
below the claim, less its margin, in both refutes it.
"""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from ...contracts.measure import Evidence, Finding, LevelFinding, Verdict
from ...contracts.scheme import Claim
from ...probe.local.orders import last_orders
from ...probe.stiffness.uniform_local import UniformDefects
from ..judge import Opinion, claim_for

MEASURE, ONE_STEP = "uniformity", "one step"
METHOD = "one step against two half steps, supremum over eps (T1)"
FEWEST = 3


def one_step_claim(evidence: Evidence) -> Claim | None:
    """Return the claim about one step; one about errors along paths is none."""
    claim, _ = claim_for(evidence.scheme, evidence.view.traits, MEASURE, ONE_STEP)
    return claim if claim is not None and ONE_STEP in claim.quantities else None


def one_step_finding(claim: Claim, record: UniformDefects, names: list[str]) -> Finding:
    """Return the finding on the order of the local weak error, uniformly in eps.

    Parameters
    ----------
    claim : Claim
    record : UniformDefects
    names : list of str
        Of the moments.
    """
    found = [_orders(record, *pair) for pair in ((record.halves, record.floor), (record.euler, record.nearly))]
    order, ahead = (np.concatenate(parts) for parts in zip(*found, strict=True))
    against = [f"{name} against {what}" for what in ("two half steps", "Euler's step") for name in names]
    worst = int(np.where(np.isnan(order), -np.inf, np.fmax(order, ahead)).argmin())
    opinion = _opinion(claim, record, order, ahead)
    return Finding(
        quantity=ONE_STEP,
        verdict=opinion.verdict,
        reason=f"local order {order[worst]:.3f} in {against[worst]}; claimed {claim.value}{opinion.reason}",
        claim=claim,
        estimate=float(order[worst]),
        method=METHOD,
        tier=1,
        details={"functional": against[worst]},
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


def _opinion(claim: Claim, record: UniformDefects, order: Array, ahead: Array) -> Opinion:
    """Return the verdict, and what is to be said beside the figures."""
    if isinstance(claim.value, str):
        return Opinion(Verdict.INCONCLUSIVE, ": this measure does not know what that means")
    bound = claim.value - claim.margin
    if np.any(np.maximum(order, ahead) < bound):
        return Opinion(Verdict.REFUTED, "")
    if np.all(np.minimum(order, ahead) >= bound):
        return Opinion(Verdict.VERIFIED, "")
    lost = int(np.sum(record.failed > 0.0))
    return Opinion(Verdict.INCONCLUSIVE, f"; steps without root at {lost} step sizes" if lost else "; not settled")
