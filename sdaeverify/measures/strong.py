"""Strong order of convergence: local defects decide, pathwise errors guard them.

The local order (T1) needs no sampling; errors at T and their maximum over the coarsest grid times (T3) guard it, and
decide alone where the one-step map cannot be probed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any, ClassVar, NamedTuple

from ..arrays import Parts
from ..forms import Problem
from ..hookspecs import hookimpl
from ..measure import Evidence, Finding, Judgement, Measure, Verdict
from ..probe.delay_links import ALGEBRAIC, YOUNG, keeps_constraint, linked
from ..probe.local_orders import LocalOpinion
from ..probe.local_strong import StrongOrder, judge_strong, strong_order
from ..probe.one_step import OneStep
from ..probe.strong_defects import LocalStrong, local_strong, no_local_order
from ..scheme import Claim, Scheme
from ..settings import Settings
from ..tally import Tally, packed, unpacked
from ..verdicts import FEWEST, FITTED, Decision, Tests, claim_for, doubted, guard, unfitted
from ._errors import AT_T, STATE, ErrorObserver
from ._level_rows import level_rows
from ._path_order import (
    EXACT,
    STILL,
    Fit,
    asymptotic_order,
    fit,
    is_exact,
    path_tests,
    stands_still,
    usable_levels,
)
from ._quantity import Quantity, quantities_of

PROBED = "local strong"
# Beside the mean, as indices of the powers that are noted.
NORMS = {"L1/2": 0, "L2": 2}

# By component.
Orders = Mapping[str, StrongOrder]


class Strong(Measure):
    """Strong order of convergence for each named component and the full state."""

    name: ClassVar[str] = "strong"

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Refuse schemes with bounded increments."""
        return f"its {scheme.law.name} increments are not Brownian: no strong order" if scheme.law.bounded else ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> ErrorObserver:
        """Return the notebook for one block."""
        return ErrorObserver(parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the local defects, where the one-step map can be probed."""
        pair = linked(scheme, view)
        return Tally() if no_local_order(*pair) else packed(PROBED, local_strong(*pair))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each component at grid times and at T, and their levels."""
        quantities = list(quantities_of(evidence))
        orders = _local_orders(evidence)
        findings = doubted([_finding(evidence, quantity, orders) for quantity in quantities])
        findings += _unknown(evidence, {quantity.name for quantity in quantities}, orders)
        rows = (level_rows(each, set(usable_levels(evidence, each)[0][-FITTED:]), NORMS) for each in quantities)
        return Judgement(tuple(findings), tuple(chain.from_iterable(rows)))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Strong()]


class _Local(NamedTuple):
    """The local order of a quantity, and what it says of the claim; none where the map cannot be probed."""

    order: StrongOrder | None = None
    opinion: LocalOpinion | None = None

    @property
    def decides(self) -> bool:
        return self.opinion is not None and self.opinion.verdict is not Verdict.INCONCLUSIVE


def _local_orders(evidence: Evidence) -> Orders:
    """Return the local order of each component and of the full state, if the one-step map was probed."""
    record = unpacked(PROBED, LocalStrong, evidence.tally)
    if record is None:
        return {}
    scheme, view = evidence.scheme, evidence.view
    orders = {name: strong_order(record, i) for i, name in enumerate(OneStep(*linked(scheme, view)).names)}
    if keeps_constraint(scheme, view):
        orders[ALGEBRAIC] = orders[YOUNG]
    return {**orders, STATE: strong_order(record)}


def _local(evidence: Evidence, name: str, orders: Orders, claim: Claim | None) -> _Local:
    order = orders.get(name)
    if order is None or claim is None or isinstance(claim.value, str):
        return _Local(order)
    return _Local(order, judge_strong(order, claim.value, sharp=evidence.scheme.sharp_locally))


def _finding(evidence: Evidence, quantity: Quantity, orders: Orders) -> Finding:
    component = quantity.name.removesuffix(AT_T)
    claim, no_claim = claim_for(evidence.scheme, evidence.view.traits, Strong.name, component)
    local = _local(evidence, component, orders, claim)
    if is_exact(evidence, quantity):
        return _with_local(_exact_finding(evidence, quantity, local, claim), local)
    usable, left_out = usable_levels(evidence, quantity)
    if len(usable[-FITTED:]) < FEWEST:
        return _with_local(_unfitted(evidence, quantity, local, claim, left_out), local)
    fitted = fit(evidence, quantity, usable, left_out)
    decision = _decision(evidence, quantity, fitted, claim, local)
    low, high = fitted.slope.interval(evidence.settings.confidence, fitted.bias.bound)
    reason = "; ".join(text for text in (decision.reason if claim else no_claim, left_out) if text)
    found = Finding(
        quantity=quantity.name,
        claim=claim,
        estimate=fitted.slope.value,
        low=low,
        high=high,
        method=_method(decision.tier, fitted.bias.reference),
        details=_details(evidence, quantity, fitted),
        **decision._replace(reason=reason)._asdict(),
    )
    return _with_local(found, local)


def _decision(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim | None, local: _Local) -> Decision:
    if claim is None:
        return Decision(Verdict.OUT_OF_SCOPE, "", 3)
    tests = path_tests(evidence, quantity, fitted, claim)
    if local.decides:
        tests = _asymptotic(evidence, quantity, fitted, claim, tests)
    return guard(local.opinion, tests, evidence)


def _asymptotic(evidence: Evidence, quantity: Quantity, fitted: Fit, claim: Claim, tests: Tests) -> Tests:
    """Let errors on coarse steps refute a local order only if the asymptotic order is too low, as well.

    Errors that level off at a wrong limit have an asymptotic order of 0.
    """
    if isinstance(claim.value, str):
        return tests
    order, half = asymptotic_order(quantity, fitted.usable, evidence.settings.confidence)
    return tests if order + half < claim.value - claim.margin else tests._replace(refuted=1.0)


def _method(tier: int, reference: str) -> str:
    return f"local order (T1), guarded by paths, {reference}" if tier == 1 else f"paths, {reference} (T3)"


def _with_local(finding: Finding, local: _Local) -> Finding:
    if local.order is None:
        return finding
    found = {
        "local_order": local.order.order,
        "local_consistent": local.order.consistent,
        "solver_plateau_h": local.order.plateau_h,
    }
    return replace(finding, details={**found, **finding.details})


def _exact_finding(evidence: Evidence, quantity: Quantity, local: _Local, claim: Claim | None) -> Finding:
    reason, verdict, tier = EXACT, Verdict.VERIFIED, 3
    if stands_still(evidence, quantity):
        reason, verdict = STILL, Verdict.INCONCLUSIVE
    if local.opinion is not None and local.decides:
        reason, verdict, tier = f"{local.opinion.reason}; {reason}", local.opinion.verdict, 1
    if claim is None:
        verdict = Verdict.OUT_OF_SCOPE
    method = "local order (T1), guarded by paths" if tier == 1 else "paths (T3)"
    return Finding(quantity=quantity.name, verdict=verdict, reason=reason, claim=claim, method=method, tier=tier)


def _unfitted(evidence: Evidence, quantity: Quantity, local: _Local, claim: Claim | None, left_out: str) -> Finding:
    found = unfitted(evidence, quantity.name, claim, left_out)
    if local.opinion is None or claim is None or found.verdict is Verdict.DIVERGED:
        return found
    if local.opinion.verdict is Verdict.REFUTED:
        method = "local order (T1)"
        return replace(found, verdict=Verdict.REFUTED, reason=local.opinion.reason, tier=1, method=method)
    return replace(found, reason=f"{local.opinion.reason}, but no paths to guard it: {found.reason}")


def _unknown(evidence: Evidence, known: set[str], orders: Orders) -> Iterator[Finding]:
    """Yield findings on the components that the truth does not know: by their local order, without a guard."""
    view = evidence.view
    start = evidence.scheme.start(view, 1, evidence.step_sizes[0])
    for name in evidence.scheme.parts(view, start):
        if name in known:
            continue
        claim, no_claim = claim_for(evidence.scheme, view.traits, Strong.name, name)
        verdict = Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE
        reason = f"the problem's truth does not know {name}" if claim else no_claim
        found = Finding(quantity=name, verdict=verdict, reason=reason, claim=claim)
        local = _local(evidence, name, orders, claim)
        if local.opinion is not None and local.opinion.verdict is Verdict.REFUTED:
            refuted, method = local.opinion.verdict, "local order (T1)"
            found = replace(found, verdict=refuted, reason=local.opinion.reason, tier=1, method=method)
        yield _with_local(found, local)


def _details(evidence: Evidence, quantity: Quantity, fitted: Fit) -> dict[str, object]:
    levels, confidence = fitted.levels, evidence.settings.confidence
    contrast = quantity.contrast(levels)
    finest, coarsest = quantity.tail(levels[-1]), quantity.tail(levels[0])
    asymptotic, half = asymptotic_order(quantity, fitted.usable, confidence)
    return {
        "std_error": fitted.slope.se,
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
        "asymptotic_order": asymptotic,
        "asymptotic_half_width": half,
        "bias_bound": fitted.bias.bound,
    }
