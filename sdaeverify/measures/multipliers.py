"""Exponents of the multipliers: how fast kappa and the remainders of lambda vanish with h at fixed states.

Estimate (3.17) of Lindner & Stroot (2017) bounds kappa and lambda^re by h^2 and Lambda^re by h; see
`probe.multiplier_orders` for the decomposition. One step is evaluated at fixed states (T1): nothing is sampled. A
quantity that is rounding at every step size keeps a claim of any order, and the reason says so.
"""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from ..contracts.measure import Evidence, Finding, Judgement, LevelFinding, Measure, Verdict
from ..contracts.scheme import Claim, Scheme, form_names
from ..contracts.settings import Settings
from ..contracts.tally import Tally, packed, unpacked
from ..forms import Multiplied, Problem
from ..probe.local.multiplier_orders import (
    QUANTITIES,
    Multipliers,
    judge_exponent,
    multiplier_orders,
    multipliers,
    no_multipliers,
)
from ..probe.local.orders import LocalOpinion
from ..registry.hookspecs import hookimpl
from .judge import claim_for

PROBED = "multipliers"
METHOD = "remainders of one step (T1)"


class MultiplierExponents(Measure):
    """Orders of kappa, lambda^re and Lambda^re of schemes that give out their multipliers."""

    name: ClassVar[str] = "multipliers"

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Refuse schemes that give out no multipliers."""
        view = scheme.view_of(problem)
        if view is None or view.capability(Multiplied) is None:
            return f"the form {form_names(scheme)} has no multiplier"
        with np.errstate(all="ignore"):
            return no_multipliers(scheme, view)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the sizes of the remainders."""
        return packed(PROBED, multipliers(scheme, view))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each multiplier that the scheme gives, and its sizes."""
        record = unpacked(PROBED, Multipliers, evidence.tally)
        if record is None:
            return Judgement((Finding(quantity="", verdict=Verdict.INCONCLUSIVE, reason="not probed"),), ())
        given = np.flatnonzero(record.given).tolist()
        findings = tuple(_finding(evidence, record, index) for index in given)
        return Judgement(findings, tuple(row for index in given for row in _levels(record, index)))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [MultiplierExponents()]


def _finding(evidence: Evidence, record: Multipliers, index: int) -> Finding:
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, MultiplierExponents.name, QUANTITIES[index])
    opinion = LocalOpinion(Verdict.OUT_OF_SCOPE, no_claim) if claim is None else _opinion(claim, record, index)
    orders = multiplier_orders(record)
    return Finding(
        quantity=QUANTITIES[index],
        verdict=opinion.verdict,
        reason=opinion.reason,
        claim=claim,
        estimate=float(orders.order[index]),
        method=METHOD,
        tier=1,
        details={"next_order": float(orders.ahead[index])},
    )


def _opinion(claim: Claim, record: Multipliers, index: int) -> LocalOpinion:
    if isinstance(claim.value, str):
        return LocalOpinion(Verdict.INCONCLUSIVE, f"this measure does not know what {claim.value!r} means")
    return judge_exponent(record, index, claim.value)


def _levels(record: Multipliers, index: int) -> Iterator[LevelFinding]:
    for h, size in zip(record.h, record.size[index], strict=True):
        yield LevelFinding(QUANTITIES[index], None, float(size), h=float(h))
