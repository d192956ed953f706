"""Judgement of claims of strong order: local defects decide, errors along paths guard them."""

from collections.abc import Iterator, Mapping
from math import inf, isfinite, isinf, isnan, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Order, bar
from ...contracts.finding import Finding, Kind, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Delayed, Problem
from ...forms.delay.linked import X
from ...probe.local.algebraic_defects import AlgebraicDefects, algebraic_defects, algebraic_order
from ...probe.local.consistency import Consistency, consistency
from ...probe.local.delay_links import Y, keeps_constraint, remove_delay, why_not_algebraic
from ...probe.local.strong_defects import LocalStrong, local_strong, why_not_local_order
from ...probe.local.strong_order import ACCURACY, StrongOrder, at_most, strong_orders, with_consistency
from ...probe.step.memory import MemoryOrders
from ...probe.step.one_step import OneStep
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.fitted_levels import FEWEST, FITTED
from ...verdicts.opinions import (
    finding,
    guard,
    local_doubt,
    local_opinion,
    no_fit,
    of_law,
    of_memory,
    of_smooth,
    too_coarse,
)
from ...verdicts.path_tests import PathTests, order_resolution, unlike
from ..path_errors.consistency import judge_departure
from ..path_errors.errors import STATE
from ..path_errors.order import (
    Fit,
    asymptotic_order,
    fit,
    judge_exact,
    lower_share,
    path_tests,
    resolve_lower_order,
    usable_levels,
)
from ..path_errors.quantity import JudgedQuantity, Quantity, unknown_components
from ..resolution import strong_resolution

# By component.
Orders = Mapping[str, StrongOrder]
# By tier; if no slope is fitted, paths guard no verdict.
METHODS = {1: Method("local order", 1, guard="paths"), 3: Method("paths", 3)}
UNFITTED_METHODS = {1: Method("local order", 1), 3: Method("paths")}
# Amount by which an order may fall short of its claim, and by which a settled one may still change.
# Measured by tests/measures/test_tolerances.py: no order of one step in the reference run is off by more.
TOLERANCE = 0.1
# A low order at few states that rises by more than this per level belongs to a layer that steps do not resolve yet.
# Measured by tests/probe/test_local_strong.py: twice the accuracy of a local order.
RISING = 2.0 * ACCURACY
STRONG_COLUMNS = {
    "local_consistent": "whether short steps follow the equation; False also if they cannot be compared with it",
    "solver_plateau_h": "step size below which the tolerance of a solver hides the local error; 0 for none",
    "rms_defect_order": "power of h of the root mean square error of one step",
    "mean_defect_order": "power of h of the mean error of one step",
    "std_error": "standard error of the order along paths",
    "order_L_half": "the same in the L1/2 norm",
    "order_L2": "the same in the L2 norm",
    "fitted_levels": "levels that the order is fitted to",
    "contrast": "order of the errors minus that of their differences; far below 0 if the limit is wrong",
    "contrast_low": "lower end of its interval",
    "contrast_high": "upper end of its interval",
    "effective_share": "effective share of the paths in the mean error; the smaller of two levels",
    "largest_share": "share of the mean error due to the path with the largest error; the larger of two levels",
    "hill_index": "tail index of the errors by Hill's estimator; the smaller of two levels",
    "heavy_tails": "whether the tails are too heavy for the interval of a mean",
    "asymptotic_order": "order as h tends to 0, with one further term of the expansion",
    "asymptotic_half_width": "half width of its interval",
    "bias_bound": "bound on the bias of the order due to the error of the reference",
}


class Span(NamedTuple):
    """The part of a run with a delay on which one step is probed; the whole run without delay.

    Attributes
    ----------
    name : str
        Of its evidence.
    links : int
        2 for steps after the first delay, 1 for steps up to it.
    until : float
        End of the part, in delays.
    """

    name: str
    links: int = 2
    until: float = np.inf


WHOLE, FIRST, SECOND = (
    Span("local strong"),
    Span("local strong up to tau", 1),
    Span("local strong up to 2 tau", 2, 2.0),
)


def probe_strong(scheme: Scheme, view: Problem, settings: Settings, span: Span = WHOLE) -> Tally:
    """Return the local defects, if the one-step map can be probed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    settings : Settings
        Of the run: y is probed on its finest mesh.
    span : Span
        Part of the run.

    Returns
    -------
    Tally
    """
    pair = remove_delay(scheme, view, span.links, span.until)
    if why_not_algebraic(scheme, view) or why_not_local_order(*pair):
        return Tally()
    record = local_strong(*pair)
    found, compared = packed(span.name, record), consistency(*pair)
    if compared is not None:
        found = found.merge(packed(_of_consistency(span), compared))
    if not all(order.converges for order in strong_orders(record)):
        found = found.merge(packed(_at_shortest(span), local_strong(*pair, shortest=True)))
    if (memory := OneStep(*pair).memory) is not None:
        found = found.merge(packed(_of_memory(span), memory))
    delta = _delta(view, settings) if span.links > 1 else 0.0
    delayed = view.capability(Delayed)
    if not delta or delayed is None or not keeps_constraint(scheme, view):
        return found
    return found.merge(packed(_of_y(span), algebraic_defects(scheme, delayed, delta)))


def _delta(view: Problem, settings: Settings) -> float:
    """Return the offset of the delay on the finest mesh: 0 if it is a multiple of the step, or if there is none."""
    delayed = view.capability(Delayed)
    return delayed.mesh(view.horizon / settings.steps[-1]).delta if delayed else 0.0


def _of_y(span: Span) -> str:
    return f"{span.name} of y"


def _of_memory(span: Span) -> str:
    return f"{span.name}, memory"


def _at_shortest(span: Span) -> str:
    return f"{span.name} at the shortest steps"


def _of_consistency(span: Span) -> str:
    return f"{span.name}, consistency"


def local_orders(evidence: Evidence, span: Span = WHOLE) -> Orders:
    """Return the local order of each component and of the full state; empty if the one-step map was not probed.

    If the scheme's y solves the constraint, its order is the smaller of the order of x and that of its own defects.
    """
    return evidence.without_paths.read(_read_orders, evidence.scheme, evidence.view, span)


def _read_orders(tally: Tally, scheme: Scheme, view: Problem, span: Span) -> Orders:
    record, shortest = (unpacked(name, LocalStrong, tally) for name in (span.name, _at_shortest(span)))
    if record is None:
        return {}
    names = tuple(OneStep(*remove_delay(scheme, view, span.links, span.until)).names)
    memory = unpacked(_of_memory(span), MemoryOrders, tally)
    most = [inf] * (len(names) + 1) if memory is None else [*memory.strong.tolist(), float(memory.strong.min())]
    compared = unpacked(_of_consistency(span), Consistency, tally)
    found = zip(
        (*names, STATE), with_consistency(strong_orders(record, shortest), compared, names), most, strict=True
    )
    orders = {name: order._replace(memory=limit) for name, order, limit in found}
    if not keeps_constraint(scheme, view):
        return orders
    own = unpacked(_of_y(span), AlgebraicDefects, tally)
    bound = np.inf if own is None else algebraic_order(own)
    return orders | {Y: at_most(orders[X], bound), STATE: at_most(orders[STATE], bound)}


def judge_order(evidence: Evidence, claim: Claim | None, order: StrongOrder | None) -> Opinion | None:
    """Return the opinion on a scheme's claim by its local order; None without a local order or a claimed order.

    Parameters
    ----------
    evidence : Evidence
        Provides whether the scheme's local order is sharp, and whether the problem's coefficients are smooth.
    claim : Claim or None
        About strong order or a consequence of it.
    order : StrongOrder or None
        Of one step, if it was probed.
    """
    if order is None or claim is None or not isinstance(claim.value, Order):
        return None
    least = claim.value.least
    found = judge_smooth(evidence, least, order, claim.value.margin)
    found = of_memory(found, least - TOLERANCE, order.memory, order.order)
    return of_smooth(found, least, evidence, at_few=order.typical >= least - TOLERANCE)


def judge_smooth(evidence: Evidence, claim: float, order: StrongOrder, margin: float = 0.0) -> Opinion:
    """Return the opinion of `judge_order` for a problem whose coefficients are known to be smooth.

    Parameters
    ----------
    evidence : Evidence
    claim : float
        Minimum order.
    order : StrongOrder
    margin : float
        Of the claim; 0 if coarse steps do not matter.
    """
    found = judge_strong(order, claim, margin=margin, sharp=evidence.scheme.local_order_is_global)
    return of_law(found, claim, evidence, paths=True)


def judge_errors(evidence: Evidence, quantity: Quantity, measure: str, order: StrongOrder | None) -> JudgedQuantity:
    """Return the finding on a quantity, and the levels to which its slope is fitted.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
    measure : str
        Name of the measure in claims.
    order : StrongOrder or None
        Its local order, if the one-step map was probed.
    """
    usable = usable_levels(evidence, quantity)
    found = _finding(evidence, quantity, coverage(evidence, measure, quantity.name), order, usable)
    return JudgedQuantity(quantity, found, frozenset(usable[0][-FITTED:].tolist()))


def _finding(
    evidence: Evidence,
    quantity: Quantity,
    covered: Coverage,
    order: StrongOrder | None,
    usable: tuple[Array, Reason],
) -> Finding:
    local, details = judge_order(evidence, covered.claim, order), _local_details(order)
    decides = local is not None and local.verdict is not Verdict.INCONCLUSIVE
    confirmed = local is not None and local.verdict is Verdict.VERIFIED and order is not None and isinf(order.order)
    if (exact := judge_exact(evidence, quantity, confirmed=confirmed)) is not None:
        opinion = local.plus(exact.reason) if local is not None and decides else exact
        opinion = opinion if covered.claim else opinion._replace(verdict=Verdict.OUT_OF_SCOPE)
        seen = strong_resolution(evidence, quantity, len(quantity.h) - 1, covered.claim)
        method = METHODS[opinion.tier]
        return finding(covered, opinion, method=method, details=details, resolution=seen)
    levels, left_out = usable
    if len(levels[-FITTED:]) < FEWEST:
        opinion = _opinion_without_fit(evidence, local, covered, left_out)
        return finding(covered, opinion, method=UNFITTED_METHODS[opinion.tier], details=details)
    fitted = fit(evidence, quantity, levels, left_out)
    opinion, order_seen = Opinion(Verdict.OUT_OF_SCOPE, covered.gap), nan
    if covered.claim is not None:
        opinion = guard(local, _tests(fitted, covered.claim, decides=decides), evidence)
        if isinstance(covered.claim.value, Order) and not decides:
            share, bias = lower_share(fitted, covered.claim.value)
            order_seen = order_resolution(share, evidence.settings.confidence, bias)
    low, high = fitted.interval
    return finding(
        covered,
        opinion.plus(left_out),
        estimate=fitted.slope.value,
        low=low,
        high=high,
        resolution=strong_resolution(evidence, quantity, int(levels[-1]), covered.claim),
        order_resolution=order_seen,
        method=METHODS[opinion.tier]._replace(reference=fitted.bias.reference),
        details={**details, **_details(fitted)},
    )


def _tests(fitted: Fit, claim: Claim, *, decides: bool) -> PathTests:
    """Return the tests of a claim by paths; `decides` means that one step decides it, and paths guard it."""
    tests = path_tests(fitted, claim)
    claimed = claim.value
    if not isinstance(claimed, Order):
        return tests
    if not decides:
        return resolve_lower_order(tests, fitted, claimed)
    blind = fitted.slope.growth_to_see(claimed.floor, fitted.evidence.settings.confidence, fitted.bias.bound)
    return _as_guard(fitted, claimed, tests._replace(blind=blind))


def _as_guard(fitted: Fit, claim: Order, tests: PathTests) -> PathTests:
    """Return the tests by paths of a claim that one step decides.

    The slope of errors on coarse steps refutes a local order only if the asymptotic order is too low as well; a test
    of the limit does not depend on the slope. Estimates that do not agree with the claim remain suspicious.
    """
    order, half = asymptotic_order(fitted)
    further = unlike(claim, fitted.slope, fitted.quantity.corrected_slope(fitted.usable), fitted.bias.above)
    suspected = min(tests.against, further)
    if order + half < claim.floor:
        return tests._replace(suspected=suspected)
    return tests._replace(refuted=max(tests.refuted, tests.limit), suspected=suspected)


def _opinion_without_fit(evidence: Evidence, local: Opinion | None, covered: Coverage, left_out: Reason) -> Opinion:
    opinion = no_fit(evidence, covered, left_out)
    if local is None or covered.claim is None or opinion.verdict is Verdict.DIVERGED:
        return opinion
    if local.verdict is Verdict.REFUTED:
        return local
    return opinion._replace(reason=local.reason.then(opinion.reason, ", but along paths "))


def unknown_findings(evidence: Evidence, measure: str, orders: Orders) -> Iterator[Finding]:
    """Yield findings on the components that the truth lacks: by their local order, without a guard.

    Parameters
    ----------
    evidence : Evidence
    measure : str
        Name of the measure in claims.
    orders : dict of str to local orders
        By component, from one step.
    """
    for name, covered, left_open in unknown_components(evidence, measure):
        order = orders.get(name)
        local, opinion, method = judge_order(evidence, covered.claim, order), left_open, None
        if local is not None and local.verdict is Verdict.REFUTED:
            opinion, method = local, UNFITTED_METHODS[1]
        yield finding(covered, opinion, method=method, details=_local_details(order))


def _local_details(order: StrongOrder | None) -> dict[str, object]:
    if order is None:
        return {}
    return {
        "local_order": order.order,
        "local_consistent": order.compared and not order.departure,
        "solver_plateau_h": order.plateau_h,
        "rms_defect_order": order.p2,
        "mean_defect_order": order.p1,
    }


def _details(fitted: Fit) -> dict[str, object]:
    quantity, levels, confidence = fitted.quantity, fitted.levels, fitted.evidence.settings.confidence
    contrast = quantity.contrast(levels)
    finest, coarsest = quantity.tail(levels[-1]), quantity.tail(levels[0])
    asymptotic, half = asymptotic_order(fitted)
    return {
        "std_error": fitted.slope.se,
        "order_L_half": quantity.slope_in(levels, 0).value,
        "order_L2": quantity.slope_in(levels, 2).value,
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


def judge_strong(order: StrongOrder, claim: float, *, margin: float = 0.0, sharp: bool = True) -> Opinion:
    """Compare a local order with a claimed minimum strong order.

    Parameters
    ----------
    order : StrongOrder
    claim : float
    margin : float
        That of the claim: if it is wider than `TOLERANCE`, an order between the two bounds is undecided.
    sharp : bool
        Whether the scheme's local order is its global one. If not, a low local order is undecided.

    Returns
    -------
    Opinion
    """
    powers = _powers(order.p2, order.p1)
    figures = f" (error of one step: {powers})" if powers else ""
    if order.departure:
        return judge_departure(order.departure)
    if order.too_coarse:
        return too_coarse(order.too_coarse)
    if isnan(order.order):
        return local_doubt(
            f"no order from one step: the step is not finite, or a solver's tolerance hides its error{figures}"
        )
    return _judge_order(order, claim, f"{_in_words(order.order)} from one step{figures}", margin, sharp=sharp)


def _judge_order(order: StrongOrder, claim: float, text: str, margin: float, *, sharp: bool) -> Opinion:
    bound = claim - TOLERANCE
    asked = bar(claim, bound)
    if order.order < bound:
        within = order.order >= claim - margin
        doubt = local_doubt(f"{text}; {asked}, refuted below {claim - margin:.3g}", against=True)
        return doubt if within else _too_low(order, claim, text, sharp=sharp)
    if order.ahead < bound:
        falling = f"{text}, falling to {order.ahead:.2f} at the next step size; {asked}"
        return local_doubt(falling, _kind(order), against=True)
    void = f"; h below {order.plateau_h:.2g} left out because of a solver's tolerance" if order.plateau_h else ""
    if not order.means:
        text = f"{_in_words(order.order)} from the RMS error of one step, the mean error is not resolved"
        return local_doubt(f"{text}{void}")
    if not order.compared:
        return local_doubt(f"{text}; short steps cannot be compared with the equation")
    return local_opinion(Verdict.VERIFIED, f"{_in_words(order.order)} from one step; {asked}{void}")


def _in_words(order: float) -> str:
    return "no error beyond round-off" if isinf(order) else f"strong order {order:.2f}"


def _kind(order: StrongOrder) -> Kind:
    """Return `Kind.INCONSISTENT` if the step's order falls to 0, so that no limit is reached; else `Kind.PLAIN`."""
    return Kind.INCONSISTENT if order.ahead <= 0.0 else Kind.PLAIN


def _powers(rms: float, mean: float) -> str:
    """Return a text with the known powers of h, of root mean squares and of means."""
    named = (("RMS", rms), ("mean", mean))
    return ", ".join(f"{name} ~ h^{value:.1f}" for name, value in named if isfinite(value))


def _too_low(order: StrongOrder, claim: float, text: str, *, sharp: bool) -> Opinion:
    bound = claim - TOLERANCE
    text = f"{text}; {bar(claim, bound)}"
    if not sharp:
        return local_doubt(f"{text}; the scheme declares that one step does not bound its order")
    if order.turns and order.p2 - 0.5 >= bound:
        return local_doubt(f"{text}; the mean error changes sign")
    low = [pair for pair in order.each or ((order.order, order.ahead),) if pair[0] < bound]
    if all(is_changing(now, ahead, bound, typical=order.typical) for now, ahead in low):
        now, ahead = min(low)
        falls = order.before >= bound
        text = (
            f"{text}; {order.before:.2f} at longer steps" if falls else f"{text}; still changing, towards {ahead:.2f}"
        )
        return local_doubt(text, _kind(order), against=falls or ahead < now)
    return local_opinion(Verdict.REFUTED, text)


def is_changing(now: float, ahead: float, bound: float, *, typical: float) -> bool:
    """Return whether an order below its bound may still reach it: it changes, or rises while most states have it.

    Parameters
    ----------
    now, ahead : float
        The order, and the one to be expected at the next smaller step.
    bound : float
        The least order that is accepted.
    typical : float
        The order at most states.
    """
    rises = ahead > now + RISING and typical >= bound
    return ahead >= bound or abs(ahead - now) > TOLERANCE or rises
