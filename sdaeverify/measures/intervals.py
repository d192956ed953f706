"""Strong order of convergence on a delay equation, separately for each interval of the delay.

Orders differ between intervals: with a deterministic history, noise that depends on the delayed state alone
is additive up to tau and multiplied by a random past afterwards. The largest errors at coarsest grid times are taken
over each ((k - 1) tau, k tau] separately, because the maximum over all times would mix them. The quantity ``x up to
tau`` is x on the first interval, ``x up to 2 tau`` on the second.
"""

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..contracts.claimed import Order, bar
from ..contracts.finding import Finding, Judgement, Method, Opinion, Verdict
from ..contracts.measure import Evidence, Measure, Snapshot
from ..contracts.scheme import Claim, Scheme
from ..contracts.settings import Settings
from ..contracts.tally import Tally, packed, unpacked
from ..forms import Delayed, Problem
from ..probe.local.consistency import (
    DelayConsistency,
    consistency_order,
    delay_consistency,
    why_not_delay_consistency,
)
from ..probe.local.delay_links import why_not_algebraic
from ..registry.hookspecs import hookimpl
from ..verdicts.coverage import coverage
from ..verdicts.opinions import finding, local_doubt, local_opinion
from .path_errors.errors import ErrorObserver
from .path_errors.quantity import ERROR_COLUMNS, judge_together, quantities_of
from .strong.findings import FIRST, SECOND, STRONG_COLUMNS, TOLERANCE, WHOLE, judge_errors, local_orders, probe_strong

NORMS = {"L2": 2}
# Relative tolerance for a grid time to be the end of an interval.
# Rounding: times k h differ by k eps at most, 2e-11 for 10^5 steps.
CLOSE = 1e-9
UP_TO = " up to "
# Interval of the local order for each suffix of a quantity's name; the last entry is for all later intervals.
SPANS = {f"{UP_TO}tau": FIRST, f"{UP_TO}2 tau": SECOND, "tau": WHOLE}
GIVEN_PAST = "one step given its past"
GIVEN = "at a fixed time, from single steps that start from the exact past"


class Intervals(Measure):
    """Strong order of convergence of each component over each interval of the delay."""

    name: ClassVar[str] = "intervals"
    follows: ClassVar[str] = "paths"
    lengthy: ClassVar[bool] = True
    detail_columns: ClassVar[Mapping[str, str]] = STRONG_COLUMNS
    level_columns: ClassVar[Mapping[str, str]] = ERROR_COLUMNS

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no delay, a single interval, or bounded increments."""
        if scheme.law.bounded:
            return f"its {scheme.law.name} increments are not Brownian, hence no strong order"
        delayed = problem.capability(Delayed)
        if delayed is None:
            return "the problem has no delay"
        return "" if delayed.delay < problem.horizon else "the problem ends within the first delay: see strong"

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> "IntervalObserver":
        """Return the observer of one block."""
        delayed = problem.capability(Delayed)
        assert delayed is not None
        return IntervalObserver(delayed.delay, problem.horizon / settings.coarsest, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the local defects on the first intervals and on all, if the one-step map can be probed."""
        found = Tally()
        for span in SPANS.values():
            found = found.merge(probe_strong(scheme, view, settings, span))
        if why_not_algebraic(scheme, view) or why_not_delay_consistency(scheme, view):
            return found
        return found.merge(packed(GIVEN_PAST, delay_consistency(scheme, view)))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each component on each interval, and their levels."""
        orders = {end: local_orders(evidence, span) for end, span in SPANS.items()}
        judged = []
        for each in quantities_of(evidence):
            own = next(found for end, found in orders.items() if each.name.endswith(end))
            judged.append(judge_errors(evidence, each, self.name, own.get(each.name.split(UP_TO, 1)[0])))
        return judge_together(judged, _past_finding(evidence), NORMS)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Intervals()]


class IntervalObserver:
    """Accumulates errors over each interval of the delay, with one `ErrorObserver` per interval.

    Parameters
    ----------
    delay : float
    h : float
        Coarsest step.
    parts : mapping of str to ndarray, shape (n, P)
        Initial components.
    settings : Settings
    """

    def __init__(self, delay: float, h: float, parts: Parts, settings: Settings) -> None:
        self.wanted: Sequence[Container[int]] = [frozenset()] * settings.levels
        self.delay, self.h, self.parts, self.settings = delay, h, parts, settings
        self.step = 0
        self.notebooks: dict[int, ErrorObserver] = {}

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step, because errors are compared on the coarsest grid."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Accumulate the errors in the interval that contains this time."""
        self.step += 1
        delays = self.step * self.h / self.delay
        interval = int(np.ceil(delays * (1.0 - CLOSE)))
        notebook = self.notebooks.setdefault(interval, ErrorObserver(self.parts, self.settings))
        notebook.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the evidence of all intervals, with the interval as suffix of the names."""
        found = Tally()
        for interval, notebook in self.notebooks.items():
            noted, suffix = notebook.tally(at_end=False), _suffix(interval)
            paths = {} if found.sums else {"paths": noted.sums["paths"]}
            sums = {name: value for name, value in noted.sums.items() if name != "paths"}
            renamed = (_with_suffix(each, suffix) for each in (sums, noted.maxima, noted.largest))
            found = found.merge(Tally(*renamed)).merge(Tally(sums=paths))
        return found


def _past_finding(evidence: Evidence) -> Iterator[Finding]:
    """Yield the finding on the consistency of one step, if it was probed."""
    record = unpacked(GIVEN_PAST, DelayConsistency, evidence.tally)
    if record is None:
        return
    covered, order = coverage(evidence, Intervals.name, GIVEN_PAST), consistency_order(record)
    opinion = _opinion(order, covered.claim) if covered.claim else Opinion(Verdict.OUT_OF_SCOPE, covered.gap, 1)
    yield finding(covered, opinion, estimate=order, method=Method("one step given its past", 1))


def _opinion(order: float, claim: Claim) -> Opinion:
    if not isinstance(claim.value, Order) or np.isnan(order):
        return local_doubt(f"order {order:.2f} {GIVEN}")
    bound = claim.value.least - TOLERANCE
    verdict = Verdict.VERIFIED if order >= bound else Verdict.REFUTED
    return local_opinion(verdict, f"order {order:.2f} {GIVEN}; {bar(claim.value.least, bound)}")


def _suffix(interval: int) -> str:
    return f"{UP_TO}tau" if interval == 1 else f"{UP_TO}{interval} tau"


def _with_suffix(values: Mapping[str, Array], suffix: str) -> dict[str, Array]:
    return {f"{name}{suffix}": value for name, value in values.items()}
