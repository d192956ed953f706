"""Orders of the multipliers: decay of kappa and the remainders of lambda in h at fixed states.

Estimate (3.17) of Lindner & Stroot (2017) bounds kappa and lambda^re by h^2 and Lambda^re by h; see
`multiplier_orders` for the decomposition. One step is evaluated at fixed states (T1), without sampling. A
quantity that is rounding at every step size satisfies a claim of any order, and the reason states this.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    NOT_PROBED,
    Evidence,
    Finding,
    Judgement,
    LevelFinding,
    Measure,
    Method,
    Opinion,
    Tally,
    Verdict,
    coverage,
    finding,
    judge_claim,
    local_doubt,
    local_opinion,
    packed,
    unpacked,
    why_not_claimed,
)
from sdaeverify.probing import Multiplied

from .multiplier_orders import QUANTITIES, Multipliers, multiplier_orders, multipliers, why_not_multipliers

PROBED = "multipliers"
METHOD = Method("remainders of one step", 1)
# Amount by which an order may fall short of the claim, and largest change to the next order of a settled one.
TOLERANCE, SETTLED = 0.1, 0.1


class MultiplierExponents(Measure):
    """Orders of kappa, lambda^re and Lambda^re of schemes that output their multipliers."""

    name: ClassVar[str] = "multipliers"
    follows: ClassVar[str] = "paths"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "next_order": "order to be expected at the next smaller step size",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: the problem or the scheme's outputs have no multipliers."""
        view = scheme.view_of(problem)
        if view is None or view.capability(Multiplied) is None:
            return f"{' or '.join(form.__name__ for form in scheme.forms)} problems have no multiplier"
        with np.errstate(all="ignore"):
            return why_not_multipliers(scheme, view)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the sizes of the remainders."""
        return packed(PROBED, multipliers(scheme, view))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each multiplier that the scheme outputs, and its sizes."""
        record = unpacked(PROBED, Multipliers, evidence.tally)
        if record is None:
            return NOT_PROBED
        given = np.flatnonzero(record.given).tolist()
        findings = tuple(_finding(evidence, record, index) for index in given)
        return Judgement(findings, tuple(row for index in given for row in _levels(record, index)))

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Return a finding for each multiplier that the scheme outputs, as on any other problem."""
        if self.refuses(scheme, view) or why_not_claimed(scheme, view, self.name):
            return ()
        return self.judge(Evidence.of_one_step(scheme, view, self.probe(scheme, view, Settings()))).findings


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [MultiplierExponents()]


def _finding(evidence: Evidence, record: Multipliers, index: int) -> Finding:
    covered = coverage(evidence, MultiplierExponents.name, QUANTITIES[index])
    opinion = judge_claim(covered, lambda claim: judge_exponent(record, index, claim.value.least), tier=1)
    orders = multiplier_orders(record)
    details = {"next_order": float(orders.ahead[index])}
    return finding(covered, opinion, estimate=float(orders.order[index]), method=METHOD, details=details)


def judge_exponent(record: Multipliers, index: int, claim: float) -> Opinion:
    """Compare the order of a quantity, and the one extrapolated to the next smaller step, with a claimed one.

    Parameters
    ----------
    record : Multipliers
    index : int
        Index of the quantity in `QUANTITIES`.
    claim : float
        Minimum order.

    Returns
    -------
    Opinion
    """
    orders = multiplier_orders(record)
    order, ahead = float(orders.order[index]), float(orders.ahead[index])
    if np.isnan(order):
        return local_doubt(_why_not_order(record))
    if np.isinf(order):
        return _rounding_opinion(record)
    bound = claim - TOLERANCE
    text = f"size ~ h^{order:.2f} in one step; claim {claim}, one-step tolerance {TOLERANCE:.3g}"
    if min(order, ahead) >= bound:
        return local_opinion(Verdict.VERIFIED, text)
    if max(order, ahead) < bound and abs(ahead - order) <= SETTLED:
        return local_opinion(Verdict.REFUTED, text)
    return local_doubt(f"{text}; still changing, to {ahead:.2f}")


def _rounding_opinion(record: Multipliers) -> Opinion:
    if record.truncated.any() or record.failed.any():
        return local_doubt("no more than round-off at the step sizes that are not truncated")
    return local_opinion(Verdict.VERIFIED, f"no more than round-off at {len(record.h)} step sizes: it vanishes here")


def _why_not_order(record: Multipliers) -> str:
    for what, share in (("is truncated", record.truncated[-1]), ("has no root", record.failed[-1])):
        if share:
            return f"no order: the step {what} at {share:.0%} of the states even at h = {record.h[-1]:.2g}"
    return "no order: the step is not finite, or a solver's tolerance hides it"


def _levels(record: Multipliers, index: int) -> Iterator[LevelFinding]:
    for h, size in zip(record.h, record.size[index], strict=True):
        yield LevelFinding(QUANTITIES[index], None, float(size), h=float(h))
