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
from ...probe.local.delay_links import Y, keeps_constraint, remove_delay, why_not_algebraic
from ...probe.local.strong_defects import LocalStrong, local_strong, why_not_local_order
from ...probe.local.strong_order import ACCURACY, StrongOrder, at_most, strong_orders
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
# Amount by which an order may fall short of its claim.
# Chosen.
TOLERANCE = 0.1
# Largest difference between the next and the last order for which a low order counts as settled.
# Chosen.
SETTLED = 0.1
# A low order at few states that rises by more than this per level belongs to a layer that steps do not resolve yet.
# Measured by sdaeverify/probe/local/strong_order.py: twice the accuracy of a local order.
RISING = 2.0 * ACCURACY
STRONG_COLUMNS = {
    "local_consistent": "whether one step follows the equation as h tends to 0",
    "solver_plateau_h": "step size below which the tolerance of a solver hides the local error; 0 for none",
    "rms_defect_order": "power of h of the root mean square error of one step",
    "mean_defect_order": "power of h of the mean error of one step",
    "euler_rms_order": "power of h of the root mean square distance of one step from Euler's",
    "euler_mean_order": "power of h of the mean distance of one step from Euler's",
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


class _Local(NamedTuple):
    """The local order of a quantity, and the opinion on the claim; both None if the map cannot be probed."""

    order: StrongOrder | None = None
    opinion: Opinion | None = None

    @property
    def decides(self) -> bool:
        return self.opinion is not None and self.opinion.verdict is not Verdict.INCONCLUSIVE

    @property
    def exact(self) -> bool:
        verified = self.opinion is not None and self.opinion.verdict is Verdict.VERIFIED
        return verified and self.order is not None and isinf(self.order.order)

    @property
    def details(self) -> dict[str, object]:
        if self.order is None:
            return {}
        return {
            "local_order": self.order.order,
            "local_consistent": self.order.consistent,
            "solver_plateau_h": self.order.plateau_h,
            "rms_defect_order": self.order.p2,
            "mean_defect_order": self.order.p1,
            "euler_rms_order": self.order.q2,
            "euler_mean_order": self.order.q1,
        }


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
    found = packed(span.name, record)
    if (memory := OneStep(*pair).memory) is not None:
        found = found.merge(packed(_of_memory(span), memory))
    if not all(order.consistent for order in strong_orders(record)):
        found = found.merge(packed(_at_shortest(span), local_strong(*pair, shortest=True)))
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


def local_orders(evidence: Evidence, span: Span = WHOLE) -> Orders:
    """Return the local order of each component and of the full state; empty if the one-step map was not probed.

    If the scheme's y solves the constraint, its order is the smaller of the order of x and that of its own defects.
    """
    return evidence.without_paths.read(_read_orders, evidence.scheme, evidence.view, span)


def _read_orders(tally: Tally, scheme: Scheme, view: Problem, span: Span) -> Orders:
    record, shortest = (unpacked(name, LocalStrong, tally) for name in (span.name, _at_shortest(span)))
    if record is None:
        return {}
    names = OneStep(*remove_delay(scheme, view, span.links, span.until)).names
    memory = unpacked(_of_memory(span), MemoryOrders, tally)
    most = [inf] * (len(names) + 1) if memory is None else [*memory.strong.tolist(), float(memory.strong.min())]
    found = zip((*names, STATE), strong_orders(record, shortest), most, strict=True)
    orders = {name: order._replace(memory=limit) for name, order, limit in found}
    if not keeps_constraint(scheme, view):
        return orders
    own = unpacked(_of_y(span), AlgebraicDefects, tally)
    bound = np.inf if own is None else algebraic_order(own)
    return orders | {Y: at_most(orders[X], bound), STATE: at_most(orders[STATE], bound)}


def _local(evidence: Evidence, covered: Coverage, order: StrongOrder | None) -> _Local:
    return _Local(order, judge_order(evidence, covered.claim, order))


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
    local = _local(evidence, covered, order)
    if (exact := judge_exact(evidence, quantity, confirmed=local.exact)) is not None:
        opinion = local.opinion.plus(exact.reason) if local.opinion is not None and local.decides else exact
        opinion = opinion if covered.claim else opinion._replace(verdict=Verdict.OUT_OF_SCOPE)
        seen = strong_resolution(evidence, quantity, len(quantity.h) - 1, covered.claim)
        method = METHODS[opinion.tier]
        return finding(covered, opinion, method=method, details=local.details, resolution=seen)
    levels, left_out = usable
    if len(levels[-FITTED:]) < FEWEST:
        opinion = _opinion_without_fit(evidence, local, covered, left_out)
        return finding(covered, opinion, method=UNFITTED_METHODS[opinion.tier], details=local.details)
    fitted = fit(evidence, quantity, levels, left_out)
    opinion, order_seen = Opinion(Verdict.OUT_OF_SCOPE, covered.gap), nan
    if covered.claim is not None:
        opinion = guard(local.opinion, _tests(fitted, covered.claim, local), evidence)
        if isinstance(covered.claim.value, Order) and not local.decides:
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
        details={**local.details, **_details(fitted)},
    )


def _tests(fitted: Fit, claim: Claim, local: _Local) -> PathTests:
    tests = path_tests(fitted, claim)
    claimed = claim.value
    if not isinstance(claimed, Order):
        return tests
    if not local.decides:
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


def _opinion_without_fit(evidence: Evidence, local: _Local, covered: Coverage, left_out: Reason) -> Opinion:
    opinion = no_fit(evidence, covered, left_out)
    if local.opinion is None or covered.claim is None or opinion.verdict is Verdict.DIVERGED:
        return opinion
    if local.opinion.verdict is Verdict.REFUTED:
        return local.opinion
    return opinion._replace(reason=local.opinion.reason.then(opinion.reason, ", but along paths "))


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
        local, opinion, method = _local(evidence, covered, orders.get(name)), left_open, None
        if local.opinion is not None and local.opinion.verdict is Verdict.REFUTED:
            opinion, method = local.opinion, UNFITTED_METHODS[1]
        yield finding(covered, opinion, method=method, details=local.details)


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
        Whether the scheme's local order is its global one. If not, a low local order is undecided, and
        consistency is required of a step from a state that the scheme itself has reached.

    Returns
    -------
    Opinion
        Refuted as inconsistent only if most states are inconsistent, at some time.
    """
    powers, bound = _powers(order.p2, order.p1), claim - TOLERANCE
    figures = f" (error of one step: {powers})" if powers else ""
    unknown = isnan(order.q2) or (order.means and isnan(order.q1))
    if not unknown and (not order.consistent or order.inconsistent_share > 0.5):
        return _inconsistent(order, bound, sharp=sharp)
    if unknown or isnan(order.order):
        return local_doubt(
            f"no order from one step: the step is not finite, or a solver's tolerance hides its error{figures}"
        )
    text, asked = f"{_in_words(order.order)} from one step{figures}", bar(claim, bound)
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
    return local_opinion(Verdict.VERIFIED, f"{_in_words(order.order)} from one step; {asked}{void}")


def _in_words(order: float) -> str:
    return "no error beyond round-off" if isinf(order) else f"strong order {order:.2f}"


def _inconsistent(order: StrongOrder, bound: float, *, sharp: bool) -> Opinion:
    if order.too_coarse:
        return too_coarse(order.too_coarse)
    text = f"one step does not follow the equation at {order.inconsistent_share:.0%} of the states"
    text = f"{text}: distance from Euler's step {_powers(order.q2, order.q1)}; at least h^0.9 and h^1.4 required"
    if order.inconsistent_share > 0.5 and not order.consistent:
        if not sharp and order.consistent_later:
            return local_doubt(f"{text}; later steps do")
        return local_opinion(Verdict.REFUTED, text, Kind.INCONSISTENT)
    if sharp and not order.consistent and order.typical < bound:
        return local_opinion(Verdict.REFUTED, f"strong order {order.typical:.2f} at most states; {text}")
    return local_doubt(text, Kind.INCONSISTENT if sharp else Kind.PLAIN, against=sharp)


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
        return local_doubt(f"{text}; still changing, towards {ahead:.2f}", _kind(order), against=ahead < now)
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
    return ahead >= bound or abs(ahead - now) > SETTLED or rises
