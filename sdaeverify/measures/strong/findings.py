"""What becomes of a claim of strong order: local defects decide, errors along paths guard them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...contracts.error_sizes import ErrorSizes
from ...contracts.measure import Evidence, Finding, Verdict
from ...contracts.scheme import Claim, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Delayed, Problem
from ...forms.delay.linked import X
from ...probe.local.algebraic_defects import AlgebraicDefects, algebraic_defects, algebraic_order
from ...probe.local.delay_links import Y, keeps_constraint, linked, loses_algebraic
from ...probe.local.orders import LocalOpinion
from ...probe.local.strong_defects import LocalStrong, local_strong, no_local_order
from ...probe.local.strong_order import StrongOrder, at_most, judge_strong, strong_order
from ...probe.step.one_step import OneStep
from ..error_sizes import of_step
from ..judge import FEWEST, FITTED, Decision, Tests, claim_for, guard, unfitted
from ..path_errors.errors import STATE
from ..path_errors.order import (
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
from ..path_errors.quantity import Quantity

# By component.
Orders = Mapping[str, StrongOrder]


class Span(NamedTuple):
    """The part of a run with a delay that one step is probed on; the whole of one without.

    Attributes
    ----------
    name : str
        Of its evidence.
    links : int
        2 for steps after the first delay, 1 for steps up to it.
    until : float
        How many delays it goes on for.
    """

    name: str
    links: int = 2
    until: float = np.inf


WHOLE, FIRST, SECOND = (
    Span("local strong"),
    Span("local strong up to tau", 1),
    Span("local strong up to 2 tau", 2, 2.0),
)


class Question(NamedTuple):
    """What is asked of a cell.

    Attributes
    ----------
    evidence : Evidence
    measure : str
        Whose claims are judged.
    orders : mapping of str to StrongOrder
        Local orders of the components, where the one-step map was probed.
    """

    evidence: Evidence
    measure: str
    orders: Orders

    def claim(self, name: str) -> tuple[Claim | None, str]:
        """Return the claim about a quantity, or None and why there is none."""
        return claim_for(self.evidence.scheme, self.evidence.view.traits, self.measure, name)


class _Local(NamedTuple):
    """The local order of a quantity, and what it says of the claim; none where the map cannot be probed."""

    order: StrongOrder | None = None
    opinion: LocalOpinion | None = None

    @property
    def decides(self) -> bool:
        return self.opinion is not None and self.opinion.verdict is not Verdict.INCONCLUSIVE


def probe_strong(scheme: Scheme, view: Problem, settings: Settings, span: Span = WHOLE) -> Tally:
    """Return the local defects, where the one-step map can be probed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    settings : Settings
        Of the run: its finest mesh is the one on which y is probed.
    span : Span
        Part of the run.

    Returns
    -------
    Tally
    """
    pair = linked(scheme, view, span.links, span.until)
    if loses_algebraic(scheme, view) or no_local_order(*pair):
        return Tally()
    found = packed(span.name, local_strong(*pair))
    delta = _delta(view, settings) if span.links > 1 else 0.0
    delayed = view.capability(Delayed)
    if not delta or delayed is None or not keeps_constraint(scheme, view):
        return found
    return found.merged(packed(_of_y(span), algebraic_defects(scheme, delayed, delta)))


def _delta(view: Problem, settings: Settings) -> float:
    """Return where the delay lies on the finest mesh: 0 where it is a multiple of the step, or there is none."""
    delayed = view.capability(Delayed)
    return delayed.mesh(view.horizon / settings.steps[-1]).delta if delayed else 0.0


def _of_y(span: Span) -> str:
    return f"{span.name} of y"


def local_orders(evidence: Evidence, span: Span = WHOLE) -> Orders:
    """Return the local order of each component and of the full state, if the one-step map was probed.

    An y that solves the constraint has the order of x or, if that is lower, the one of its own defects.
    """
    record = unpacked(span.name, LocalStrong, evidence.tally)
    if record is None:
        return {}
    scheme, view = evidence.scheme, evidence.view
    names = OneStep(*linked(scheme, view, span.links, span.until)).names
    orders = {name: strong_order(record, i) for i, name in enumerate(names)} | {STATE: strong_order(record)}
    if not keeps_constraint(scheme, view):
        return orders
    own = unpacked(_of_y(span), AlgebraicDefects, evidence.tally)
    bound = np.inf if own is None else algebraic_order(own)
    return orders | {Y: at_most(orders[X], bound), STATE: at_most(orders[STATE], bound)}


def step_sizes(evidence: Evidence) -> dict[str, ErrorSizes]:
    """Return the sizes of the defects of one step, if the one-step map was probed."""
    record = unpacked(WHOLE.name, LocalStrong, evidence.tally)
    if record is None:
        return {}
    return dict(of_step(record, list(OneStep(*linked(evidence.scheme, evidence.view)).names)))


def _local(question: Question, name: str, claim: Claim | None) -> _Local:
    order = question.orders.get(name)
    if order is None or claim is None or isinstance(claim.value, str):
        return _Local(order)
    return _Local(
        order, judge_strong(order, claim.value, margin=claim.margin, sharp=question.evidence.scheme.sharp_locally)
    )


def finding(question: Question, quantity: Quantity, claimed: str, component: str) -> Finding:
    """Return the finding on a quantity.

    Parameters
    ----------
    question : Question
    quantity : Quantity
    claimed : str
        Its name in claims.
    component : str
        Whose local order is its own.

    Returns
    -------
    Finding
    """
    evidence = question.evidence
    claim, no_claim = question.claim(claimed)
    local = _local(question, component, claim)
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

    Errors that level off at a wrong limit have an asymptotic order of 0. Where it is not known well enough for that
    to show, nothing is refuted by the slope on coarse steps, but more paths are asked for.
    """
    if isinstance(claim.value, str):
        return tests
    bound, confidence = claim.value - claim.margin, evidence.settings.confidence
    order, half = asymptotic_order(quantity, fitted.usable, confidence)
    tests = tests._replace(blind=fitted.slope.growth_to_see(bound, confidence, fitted.bias.bound))
    if order + half < bound:
        return tests
    return tests._replace(refuted=1.0, suspected=1.0 if half < bound else min(tests.refuted, tests.suspected))


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


def unknown(question: Question, known: set[str]) -> Iterator[Finding]:
    """Yield findings on the components that the truth does not know: by their local order, without a guard."""
    evidence = question.evidence
    start = evidence.scheme.start(evidence.view, 1, evidence.step_sizes[0])
    for name in evidence.scheme.parts(evidence.view, start):
        if name in known:
            continue
        claim, no_claim = question.claim(name)
        verdict = Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE
        reason = f"the problem's truth does not know {name}" if claim else no_claim
        found = Finding(quantity=name, verdict=verdict, reason=reason, claim=claim)
        local = _local(question, name, claim)
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
