"""Strong order of convergence: local defects decide, pathwise errors guard them.

The local order (T1) needs no sampling. Errors at T and their maximum over the coarsest grid times (T3) guard it, and
decide alone if the one-step map cannot be probed.
"""

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from ...arrays import Parts
from ...contracts.finding import Finding, Judgement
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import AT_T, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ...registry.hookspecs import hookimpl
from ..path_errors.errors import ErrorObserver
from ..path_errors.quantity import ERROR_COLUMNS, JudgedQuantity, Quantity, judge_together, quantities_of
from .findings import (
    STRONG_COLUMNS,
    Orders,
    judge_errors,
    local_orders,
    probe_strong,
    unknown_findings,
)
from .members import member_findings

# Norms in addition to the mean, as indices of the recorded powers.
NORMS = {"L_half": 0, "L2": 2}


class Strong(Measure):
    """Strong order of convergence for each named component and the full state."""

    name: ClassVar[str] = "strong"
    follows: ClassVar[str] = "paths"
    resolved_by_steps: ClassVar[bool] = True
    detail_columns: ClassVar[Mapping[str, str]] = STRONG_COLUMNS
    level_columns: ClassVar[Mapping[str, str]] = {
        **ERROR_COLUMNS,
        "estimate_L_half": "the error in the L1/2 norm",
        "relative": "mean relative error at T",
        "relative_low": "lower end of its interval",
        "relative_high": "upper end of its interval",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: bounded increments."""
        return f"its {scheme.law.name} increments are not Brownian: no strong order" if scheme.law.bounded else ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> ErrorObserver:
        """Return the observer of one block."""
        return ErrorObserver(parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the local defects, if the one-step map can be probed."""
        return probe_strong(scheme, view, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each component at grid times and at T, and their levels."""
        orders = local_orders(evidence)
        judged = [_judge(evidence, quantity, orders) for quantity in quantities_of(evidence)]
        return judge_together(judged, unknown_findings(evidence, self.name, orders), NORMS)

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Return a finding for each component, by the order of one step."""
        return member_findings(scheme, view, self.name)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Strong()]


def _judge(evidence: Evidence, quantity: Quantity, orders: Orders) -> JudgedQuantity:
    component = quantity.name.removesuffix(AT_T)
    return judge_errors(evidence, quantity, Strong.name, orders.get(component))
