"""Strong orders by one step alone, without paths: on random members of a form, and on problems."""

from collections.abc import Iterator

from ...arrays import Array
from ...contracts.claimed import Order
from ...contracts.finding import Finding
from ...contracts.measure import Evidence
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ...probe.local.consistency import consistency_at
from ...probe.local.delay_links import remove_delay, why_not_algebraic
from ...probe.local.strong_defects import local_strong_from, why_not_from
from ...probe.local.strong_order import strong_orders, with_consistency
from ...probe.step.one_step import OneStep
from ...probe.step.states import states_near_start
from ...verdicts.coverage import coverage
from ...verdicts.opinions import finding, local_doubt
from ..path_errors.errors import STATE
from .findings import UNFITTED_METHODS, Orders, judge_order, judge_smooth, local_orders, probe_strong


def member_findings(scheme: Scheme, view: Problem, measure: str) -> Iterator[Finding]:
    """Yield a finding for each component of a random member: the order of one step near its start.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        The member, in the scheme's form.
    measure : str
        Name of the measure in claims.
    """
    evidence, pair = Evidence.of_one_step(scheme, view), remove_delay(scheme, view)
    step = OneStep(*pair)
    why = why_not_algebraic(scheme, view) or step.why_not_memoryless()
    why = why or step.why_not_probed(beside=True, run=False, levy=True) or why_not_from(step, _states_of(step))
    orders = {} if why else _member_orders(step)
    for name in orders or (STATE,):
        covered = coverage(evidence, measure, name)
        if covered.claim is None or not isinstance(covered.claim.value, Order):
            continue
        if why:
            yield finding(covered, local_doubt(why))
            continue
        opinion = judge_smooth(evidence, covered.claim.value.least, orders[name])
        yield finding(covered, opinion, method=UNFITTED_METHODS[1], details={"local_order": orders[name].order})


def step_findings(scheme: Scheme, problem: Problem, view: Problem, measure: str) -> Iterator[Finding]:
    """Yield a finding for each component of a problem whose order is claimed: that of one step at all probe states.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
    view : Problem
        The problem in the scheme's form.
    measure : str
        Name of the measure in claims.
    """
    settings = Settings()
    evidence = Evidence(scheme, problem, view, settings, probe_strong(scheme, view, settings), Tally())
    for name, order in local_orders(evidence).items():
        covered = coverage(evidence, measure, name)
        opinion = judge_order(evidence, covered.claim, order)
        if opinion is not None:
            yield finding(covered, opinion, estimate=order.order)


def _states_of(step: OneStep) -> Array:
    return states_near_start(step.view, step.equation)


def _member_orders(step: OneStep) -> Orders:
    x = _states_of(step)
    names, orders = tuple(step.names), strong_orders(local_strong_from(step.scheme, step.view, x))
    return dict(zip((*names, STATE), with_consistency(orders, consistency_at(step, x), names), strict=True))
