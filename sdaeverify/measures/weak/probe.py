"""Weak orders without sampling, and their comparison with a claim."""

from functools import lru_cache
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from ...contracts.claimed import Order, bar
from ...contracts.finding import Finding, Kind, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Delayed, Problem
from ...probe.linear.moments import (
    MomentErrors,
    delay_moment_errors,
    moment_errors,
    moment_orders,
    observable_order,
    quadratic_form,
    why_not_delay_moments,
    why_not_moments,
)
from ...probe.local import weak_defects as local
from ...probe.local.delay_links import remove_delay, why_not_algebraic
from ...probe.local.smoothness import Smoothness, smoothness
from ...probe.local.weak_defects import SemigroupReference, reference_from, weak_reference
from ...probe.local.weak_order import LocalWeak, WeakOrder, weak_order
from ...probe.operator.functional_orders import (
    FunctionalOrder,
    functional_orders,
    least_order,
    widen,
)
from ...probe.operator.point_law import PointLaw, largest_errors_order, point_law, why_not_point_law
from ...probe.operator.transition import why_not_operator
from ...probe.operator.transition_errors import TransitionErrors, chart_observables, weak_errors
from ...probe.step.memory import MemoryOrders
from ...probe.step.one_step import OneStep
from ...probe.step.states import cloud, states_near_start
from ...probe.step.times import first_time
from ...probe.step.two_rules import SHAPED
from ...verdicts.coverage import Coverage, claim_for
from ...verdicts.opinions import (
    finding,
    local_doubt,
    local_opinion,
    of_law,
    of_memory,
    of_smooth,
    too_coarse,
    up_to,
)
from ..means import known_mean

LOCAL, MOMENTS, OPERATOR, POINTS = "local weak", "moments", "operator", "points"
MEMORY = "memory"
AT_SHORTEST = f"{LOCAL} at the shortest steps"
# Amount by which an order without sampling error may fall short of its claim.
# Theorem: orders of schemes are multiples of 1/2, and this is half of that.
TOLERANCE = 0.25
# Number of step sizes of the operator, and of further ones if those do not settle an order.
# Size: step sizes of an operator.
FIRST, FURTHER = 4, 4
# For 2688 jumps and kinks at random places, no order was this far below the true one: `test_point_law`, slow.
# Measured by tests/probe/test_point_law.py.
FAR_BELOW = 1.0
# Maximum weak order with interpolation between mesh points.
# Theorem: a Brownian bridge at delta h has variance delta (1 - delta) h.
INTERPOLATED = 1.0
# A failure at a smaller part of the states may be a tolerance or a singular state.
# Chosen.
MANY = 0.25


class WeakProbe(NamedTuple):
    """Evidence of the deterministic tiers; None if one does not apply or was not needed.

    Attributes
    ----------
    local : WeakOrder or None
    order : float
        The local weak order, NaN if the map was not probed.
    moments : tuple of float, or None
        Interval of the smallest order of the propagated moments.
    orders : mapping of str to FunctionalOrder
        Global orders of observables by the transition operator.
    memory : float
        Weak order of the change by the memory of a run; infinite without memory.
    """

    local: WeakOrder | None
    order: float
    moments: tuple[float, float] | None
    orders: dict[str, FunctionalOrder]
    memory: float = inf

    @property
    def details(self) -> dict[str, object]:
        """Additional columns of a finding."""
        found: dict[str, object] = {} if self.local is None else {"local_order": self.order}
        return found if self.moments is None else {**found, "moment_order": _middle(*self.moments)}


def probe_weak(scheme: Scheme, view: Any, settings: Settings) -> Tally:
    """Return local weak defects; moments for linear problems; the operator if the local orders do not decide.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        In the scheme's form.
    settings : Settings
        Numbers of steps, for moments and operators.
    """
    evidence, verdicts = Tally(), [Verdict.INCONCLUSIVE]
    pair = remove_delay(scheme, view)
    if not (why_not_algebraic(scheme, view) or local.why_not_local_weak(*pair)):
        found = local.local_weak(*pair, _reference)
        order, memory = weak_order(found), OneStep(*pair).memory
        evidence, verdicts = evidence.merge(packed(LOCAL, found)), _claimed_verdicts(order, scheme)
        evidence = evidence if memory is None else evidence.merge(packed(MEMORY, memory))
        if Verdict.REFUTED in verdicts:
            evidence = evidence.merge(packed(AT_SHORTEST, local.local_weak(*pair, _reference, shortest=True)))
    if view.capability(Delayed):
        if not why_not_delay_moments(scheme, view, settings.steps):
            evidence = evidence.merge(packed(MOMENTS, delay_moment_errors(scheme, view, settings.steps)))
    elif not why_not_moments(scheme, view):
        evidence = evidence.merge(packed(MOMENTS, moment_errors(scheme, view, settings.steps)))
    elif Verdict.INCONCLUSIVE in verdicts and view.chart is not None and not why_not_operator(scheme, view):
        evidence = evidence.merge(packed(OPERATOR, _operator(scheme, view, settings)))
    if not why_not_point_law(scheme, view) and _claims_rough(scheme, view):
        evidence = evidence.merge(packed(POINTS, point_law(scheme, view, settings.coarsest)))
    return evidence


def _claims_rough(scheme: Scheme, view: Problem) -> bool:
    """Return whether a scheme claims an order of an observable that is not smooth."""
    claimed = (name for name in view.observables if claim_for(scheme, view.traits, "weak", name).claim)
    return any(smoothness(view, name) is not Smoothness.SMOOTH for name in claimed)


def weak_probe(evidence: Evidence) -> WeakProbe:
    """Return the deterministic evidence of a cell."""
    return evidence.without_paths.read(_read_probe, evidence.view)


def _read_probe(tally: Tally, view: Problem) -> WeakProbe:
    record = unpacked(OPERATOR, TransitionErrors, tally)
    orders: dict[str, FunctionalOrder] = {}
    if record is not None and not record.why_not_evidence:
        orders = _operator_orders(view, record)
    defects, shortest = (unpacked(name, LocalWeak, tally) for name in (LOCAL, AT_SHORTEST))
    moments = unpacked(MOMENTS, MomentErrors, tally)
    order = None if defects is None else weak_order(defects, shortest)
    memory = unpacked(MEMORY, MemoryOrders, tally)
    return WeakProbe(
        order,
        nan if order is None else order.order,
        None if moments is None else least_order(widen(moment_orders(moments), view)),
        orders,
        inf if memory is None else float(memory.weak),
    )


def judge_probe(evidence: Evidence, claim: Claim | None, observable: str) -> tuple[Opinion | None, bool]:
    """Return the opinion of the deterministic tiers on a claim about an observable.

    The local order decides. Moments can revoke its verification, and decide if it does not; so does the
    operator for the observables it is informative about. A claim that names its observables is judged by these alone:
    the smallest local order of all test functions is sufficient for each of them, but not necessary. An observable
    with a jump or a kink is left open, because smooth functions, such as polynomials, do not represent it.

    Parameters
    ----------
    evidence : Evidence
        Of a cell; its evidence of tiers T1 and T2 is used.
    claim : Claim or None
        Claim that covers the observable.
    observable : str

    Returns
    -------
    Opinion or None
    bool
        Whether the second tier confirms the first one at T, without sampling.
    """
    if claim is None or not isinstance(claim.value, Order):
        return None, False
    least = claim.value.least
    known = observable in evidence.view.observables
    if known and (found := smoothness(evidence.view, observable)) is not Smoothness.SMOOTH:
        return _judge_rough(evidence, least, observable, found), False
    probed, tolerance = weak_probe(evidence), max(TOLERANCE, claim.value.margin)
    sharp = evidence.scheme.local_order_is_global
    opinion = evidence.without_paths.read(_judge_local, evidence.view, least, tolerance, sharp)
    opinion = opinion and of_smooth(of_law(opinion, least, evidence, paths=False), least, evidence)
    opinion = opinion and of_mesh(opinion, least, evidence)
    final = opinion is not None and opinion.final
    if claim.quantities and known and not final:
        return _judge_named(evidence, claim.value, observable, opinion)
    if opinion is not None and (final or opinion.verdict is Verdict.REFUTED):
        return opinion, False
    further = _up_to_memory(_global(probed, least, observable), least - tolerance, probed)
    # A contradiction by one step is not overruled at T: moments and means on a chart may miss the states it was seen
    # at.
    undecided = opinion is None or (opinion.verdict is Verdict.INCONCLUSIVE and not opinion.speaks_against)
    if further is not None and (undecided or further.final or further.verdict is Verdict.REFUTED):
        return further, False
    return opinion, further is not None and further.verdict is Verdict.VERIFIED


def of_mesh(opinion: Opinion, claim: float, evidence: Evidence) -> Opinion:
    """Return the opinion of a local order, left open for claims above 1 if lagged values are interpolated.

    One step has the older solution at its ends. Between the points x_k and x_{k+1} of a mesh, Brownian motion is a
    bridge of variance delta (1 - delta) h about the line through them. So functions that are nonlinear in a lagged
    value have a mean with an error of order h.

    Parameters
    ----------
    opinion, claim, evidence
        As of `of_smooth`.
    """
    delayed = evidence.view.capability(Delayed)
    if delayed is None or not delayed.mesh(evidence.step_sizes[-1]).delta:
        return opinion
    return up_to(INTERPOLATED, opinion, claim, "for delays of whole steps, but here lagged values are interpolated")


def _judge_rough(evidence: Evidence, claim: float, observable: str, found: Smoothness) -> Opinion:
    """Return the opinion on an observable with a jump or a kink: open by one step, but by a law on few points.

    Errors on a lattice fluctuate, and may be small by accident, so small errors verify no claim.
    """
    words = f"{observable} has {found} on the range of solutions: one step decides only smooth observables"
    silent = local_doubt(words, Kind.NOT_SMOOTH)
    law = unpacked(POINTS, PointLaw, evidence.tally)
    if law is None:
        return silent
    place = list(evidence.view.observables).index(observable)
    exact = known_mean(evidence.problem, observable)
    order = largest_errors_order(law, place, nan if exact is None else exact)
    asked = bar(claim, claim - TOLERANCE)
    if not order < claim - TOLERANCE:
        return silent
    text = f"order {order:.2f} of the largest errors of E[{observable}] at T, by the law of its points; {asked}"
    if order < claim - FAR_BELOW:
        return Opinion(Verdict.REFUTED, Reason(text, Kind.NOT_SMOOTH), 2)
    return local_doubt(text, Kind.NOT_SMOOTH, against=True)


def _judge_named(
    evidence: Evidence, claim: Order, observable: str, opinion: Opinion | None
) -> tuple[Opinion | None, bool]:
    """Return the opinion on a claim that names this observable, given that of one step on all test functions.

    The second value is as for `judge_probe`.
    """
    least = claim.least - max(TOLERANCE, claim.margin)
    further = _up_to_memory(_global_of_one(evidence, claim.least, observable), least, weak_probe(evidence))
    if further is not None:
        both = opinion is not None and {opinion.verdict, further.verdict} == {Verdict.VERIFIED}
        return (opinion if both else further), both
    if opinion is None or opinion.verdict is not Verdict.REFUTED:
        return opinion, False
    own = evidence.without_paths.read(_read_own, evidence.view, observable)
    if own is not None:
        judged = _judge_in_runs(own, claim.least, max(TOLERANCE, claim.margin), weak_probe(evidence).memory)
        judged = unless_taken_back(judged, sharp=evidence.scheme.local_order_is_global)
        if judged.verdict is Verdict.REFUTED:
            return judged, False
    return local_doubt(f"{opinion.reason}, for other functions; {observable} may have a higher order"), False


def _global_of_one(evidence: Evidence, claim: float, observable: str) -> Opinion | None:
    """Return the opinion on one observable at T without sampling, or None."""
    form, record = quadratic_form(evidence.view, observable), unpacked(MOMENTS, MomentErrors, evidence.tally)
    found = observable_order(record, form) if form is not None and record is not None else None
    if found is None:
        return _global(weak_probe(evidence)._replace(moments=None), claim, observable)
    (found,) = widen([found], evidence.view)
    text = f"weak order {found.order:.2f} of E[{observable}] at T by moment equations"
    return _opinion(found.low, found.high, claim, text) if found.informative else None


def _read_own(tally: Tally, view: Problem, observable: str) -> WeakOrder | None:
    """Return the local weak order of a quadratic observable alone, or None."""
    form, record, ito = quadratic_form(view, observable), unpacked(LOCAL, LocalWeak, tally), view.ito()
    if form is None or record is None or ito is None or ito.dimension != int(record.dimension) or not form.size:
        return None
    made_up = local.frame_of(cloud(view, ito)).coefficients(form.linear, form.square)
    return weak_order(record.combine(made_up))._replace(function=observable)


def _judge_local(tally: Tally, view: Problem, claim: float, tolerance: float, sharp: bool) -> Opinion | None:
    probed = tally.read(_read_probe, view)
    if probed.local is None:
        return None
    return unless_taken_back(_judge_in_runs(probed.local, claim, tolerance, probed.memory), sharp=sharp)


def unless_taken_back(opinion: Opinion, *, sharp: bool) -> Opinion:
    """Return the opinion of one step on a weak order, left open if later steps cancel its errors.

    Parameters
    ----------
    opinion : Opinion
        On the order of one step.
    sharp : bool
        Whether that is the order at T, see `Scheme.local_order_is_global`.
    """
    if sharp or not (opinion.verdict is Verdict.REFUTED or opinion.speaks_against):
        return opinion
    return local_doubt(f"{opinion.reason}; the scheme declares that later steps cancel errors of single steps")


def _judge_in_runs(order: WeakOrder, claim: float, tolerance: float, memory: float) -> Opinion:
    return of_memory(judge_weak(order, claim, tolerance), claim - tolerance, memory, order.order)


def _global(probed: WeakProbe, claim: float, observable: str) -> Opinion | None:
    if probed.moments is not None:
        return _opinion(*probed.moments, claim, f"weak order {_in_words(*probed.moments)} at T by moment equations")
    found = probed.orders.get(observable)
    if found is None or not found.informative:
        return None
    text = f"weak order {found.order:.2f} of E[{observable}] at T by the transition operator"
    return _opinion(found.low, found.high, claim, text)


def _up_to_memory(further: Opinion | None, least: float, probed: WeakProbe) -> Opinion | None:
    """Return the opinion at T, which verifies no order above that of the changes by the memory of a run.

    Moments are propagated by a step whose memory is the same at all times.

    Parameters
    ----------
    further : Opinion or None
    least : float
        The smallest order that is accepted as the claimed one.
    probed : WeakProbe
    """
    if further is None or further.verdict is not Verdict.VERIFIED:
        return further
    return of_memory(further, least, probed.memory, inf)


def _opinion(low: float, high: float, claim: float, text: str) -> Opinion | None:
    bound = claim - TOLERANCE
    reason = Reason(f"{text}; {bar(claim, bound)}", Kind.WRONG_LIMIT if high < TOLERANCE else Kind.PLAIN)
    if low >= bound:
        return Opinion(Verdict.VERIFIED, reason, 2)
    return Opinion(Verdict.REFUTED, reason, 2) if high < bound else None


def _operator(scheme: Scheme, view: Any, settings: Settings) -> TransitionErrors:
    """Return errors by the operator, on further step sizes if the first ones do not settle the claims."""
    steps = [settings.coarsest * 2**level for level in range(FIRST + FURTHER)]
    record = weak_errors(scheme, view, steps[:FIRST])
    orders = _operator_orders(view, record)
    claims = {name: claim_for(scheme, view.traits, "weak", name).claim for name in orders}
    least = {name: c.value.least for name, c in claims.items() if c and isinstance(c.value, Order)}
    if record.why_not_evidence or all(
        orders[name].fixed or orders[name].low >= p - TOLERANCE for name, p in least.items()
    ):
        return record
    return record.extend(weak_errors(scheme, view, steps[FIRST:]))


def _operator_orders(view: Problem, record: TransitionErrors) -> dict[str, FunctionalOrder]:
    return dict(zip(chart_observables(view), widen(functional_orders(record), view), strict=True))


def _in_words(low: float, high: float) -> str:
    if isfinite(low) and not isfinite(high):
        return f"at least {low:.2f}"
    return f"at most {high:.2f}" if isfinite(high) and not isfinite(low) else f"{_middle(low, high):.2f}"


def _middle(low: float, high: float) -> float:
    # NaN for an open interval.
    return low if low == high else 0.5 * (low + high) if isfinite(low) and isfinite(high) else nan


def _claimed_verdicts(order: WeakOrder, scheme: Scheme) -> list[Verdict]:
    """Return the verdicts of one step on the orders that a scheme claims."""
    values = (claim.value for claim in scheme.promises if claim.measure == "weak")
    orders = (value for value in values if isinstance(value, Order))
    judged = (judge_weak(order, value.least, max(TOLERANCE, value.margin)) for value in orders)
    return [unless_taken_back(opinion, sharp=scheme.local_order_is_global).verdict for opinion in judged]


@lru_cache(maxsize=16)
def _reference(view: Problem, steps: local.Steps, *, further: bool = False) -> SemigroupReference:
    # Cached per problem and form, because all schemes use it; problems are compared by identity.
    return weak_reference(view, steps, further=further)


def member_finding(scheme: Scheme, view: Problem, covered: Coverage) -> Finding:
    """Return the finding on a claim of an order for a random member: the local weak order near its start.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        The member, in the scheme's form.
    covered : Coverage
        With a claim of an order.
    """
    pair, claim = remove_delay(scheme, view), covered.claim
    nodes = local.why_not_nodes(scheme, pair[1])
    step = OneStep(*pair)
    why = why_not_algebraic(scheme, view) or nodes or step.why_not_probed(run=False) or step.why_not_memoryless()
    why = why or local.why_not_from(step, states_near_start(pair[1], step.equation))
    if why or claim is None or not isinstance(claim.value, Order):
        return finding(covered, local_doubt(why))
    order, value = weak_order(local.local_weak_from(*pair, _reference_near_start(pair[1]))), claim.value
    opinion = unless_taken_back(judge_weak(order, value.least, TOLERANCE), sharp=scheme.local_order_is_global)
    evidence = Evidence.of_one_step(scheme, view)
    opinion = of_law(opinion, value.least, evidence, paths=False)
    return finding(covered, opinion, method=Method("local weak order", 1), details={"local_order": order.order})


@lru_cache(maxsize=8)
def _reference_near_start(view: Problem) -> SemigroupReference:
    # Cached per member, because all schemes use it; problems are compared by identity.
    ito = view.ito()
    assert ito is not None
    steps = tuple((first_time(view.horizon), size) for size in local.sizes(view).tolist())
    return reference_from(view, states_near_start(view, ito), steps)


def judge_weak(order: WeakOrder, claim: float, tolerance: float = 0.25) -> Opinion:
    """Compare local orders with a claimed minimum weak order.

    Parameters
    ----------
    order : WeakOrder
    claim : float
    tolerance : float
        Amount by which an order may fall short of the claim.

    Returns
    -------
    Opinion
        Refuted only if settled orders are too low at a quarter of the states at some time, and inconsistent with the
        equation if one of them is 0. A defect with an accidentally small leading coefficient may change its sign as h
        tends to 0, and its order is not settled: it is ignored if this happens at fewer states, for every phi, or at
        one of several.
    """
    void = f"; h below {order.plateau_h:.2g} left out because of a solver's tolerance" if order.plateau_h else ""
    asked = f"{bar(claim, claim - tolerance)}{void}"
    low = order.orders < claim - tolerance
    short = low & order.settled & (order.last < claim - tolerance)
    moving = low & ~short
    if why := _why_silent(order, claim - tolerance):
        return local_doubt(why + void)
    states = np.asarray(short.any(axis=0))
    share, (few, among) = float(order.share(states)), order.count_states(states)
    if share and order.rises(short, claim - tolerance):
        return too_coarse(order.h)
    kind = Kind.INCONSISTENT if np.any(order.orders[short] < TOLERANCE) else Kind.PLAIN
    if share >= MANY:
        return local_opinion(Verdict.REFUTED, f"{order.least(short)}, low at {few} of {among} states; {asked}", kind)
    if share:
        text = f"{order.least(short)} at {few} of {among} probed states, so that paths cannot verify the claim{void}"
        return local_doubt(text, kind, against=True)
    if order.at_many(moving, MANY):
        return local_doubt(f"{order.least(moving)}, still changing with h; {asked}")
    least = np.min(order.orders, where=order.settled & ~low, initial=np.inf)
    figure = "no error beyond round-off" if np.isinf(least) else f"weak order {least:.2f}"
    left_out = f" ({moving.sum()} of {moving.size} errors change sign)" if moving.any() else ""
    return local_opinion(Verdict.VERIFIED, f"{figure} from one step{left_out}; {asked}")


def _why_silent(order: WeakOrder, bound: float) -> str:
    """Return why one step does not determine a weak order, or an empty string."""
    if np.isnan(order.orders).all(axis=0).any() or not order.orders.size:
        return "no weak order from one step: the step is not finite, or a solver's tolerance hides its error"
    if order.differing_share(bound) >= MANY:
        return f"two quadrature rules for the noise differ at order {order.rules.min():.2f}: {SHAPED}"
    return ""
