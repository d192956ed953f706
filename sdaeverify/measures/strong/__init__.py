"""Strong order of convergence: local defects decide, pathwise errors guard them.

The local order (T1) needs no sampling. Errors at T and their maximum over the coarsest grid times (T3) guard it, and
decide alone if the one-step map cannot be probed. On linear equations, root mean square errors of steps that are
polynomials of their noise are known without sampling at each step size, and so is the leading term C h^p.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import Any, ClassVar

import numpy as np

from ...arrays import Parts
from ...contracts.finding import Finding, Judgement
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import AT_T, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Delayed, Problem
from ...probe.linear.strong_errors import StrongErrors, strong_errors, why_not_strong_errors
from ...probe.operator.functional_orders import Coefficient, leading_columns, leading_error, order_of
from ...probe.step.one_step import why_not_resolved
from ...registry.hookspecs import hookimpl
from ..path_errors.errors import STATE, ErrorObserver
from ..path_errors.quantity import ERROR_COLUMNS, JudgedQuantity, Quantity, judge_together, quantities_of
from .findings import (
    STRONG_COLUMNS,
    TOLERANCE,
    Orders,
    judge_errors,
    local_orders,
    probe_strong,
    unknown_findings,
)
from .members import member_findings, step_findings

# Norms in addition to the mean, as indices of the recorded powers.
NORMS = {"L_half": 0, "L2": 2}
# Name of the evidence.
SIZE = "mean square errors"


class Strong(Measure):
    """Strong order of convergence for each named component and the full state."""

    name: ClassVar[str] = "strong"
    follows: ClassVar[str] = "paths"
    resolved_by_steps: ClassVar[bool] = True
    step_tolerance: ClassVar[float] = TOLERANCE
    detail_columns: ClassVar[Mapping[str, str]] = {
        **STRONG_COLUMNS,
        **leading_columns("root mean square error at T"),
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        **ERROR_COLUMNS,
        "estimate_L_half": "the error in the L1/2 norm",
        "relative": "mean relative error at T",
        "relative_low": "lower end of its interval",
        "relative_high": "upper end of its interval",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: bounded increments."""
        return (
            f"its {scheme.law.name} increments are not Brownian, hence no strong order" if scheme.law.bounded else ""
        )

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> ErrorObserver:
        """Return the observer of one block."""
        return ErrorObserver(parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the local defects, if the one-step map can be probed."""
        return probe_strong(scheme, view, settings).merge(probe_size(scheme, view, settings))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each component at grid times and at T, and their levels."""
        orders = local_orders(evidence)
        judged = [_judge(evidence, quantity, orders) for quantity in quantities_of(evidence)]
        return judge_together(judged, unknown_findings(evidence, self.name, orders), NORMS)

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Return a finding for each component, by the order of one step."""
        return member_findings(scheme, view, self.name)

    def judge_step(self, scheme: Scheme, problem: Problem, view: Any) -> Iterable[Finding]:
        """Return a finding for each component with a claimed order, by the order of one step."""
        return step_findings(scheme, problem, view, self.name)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Strong()]


def _judge(evidence: Evidence, quantity: Quantity, orders: Orders) -> JudgedQuantity:
    component = quantity.name.removesuffix(AT_T)
    found = judge_errors(evidence, quantity, Strong.name, orders.get(component))
    sized = replace(found.finding, details={**found.finding.details, **size_columns(evidence, quantity.name)})
    return found._replace(finding=sized)


# The size of errors: root mean squares at T, extrapolated to their leading term.


def probe_size(scheme: Scheme, view: Any, settings: Settings) -> Tally:
    """Return mean square errors without sampling, if the equation is linear and the step is linear in the state.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        What the scheme sees.
    settings : Settings
        Of the run: its step sizes are the coarsest ones.
    """
    if view.capability(Delayed) or view.has_constraints or why_not_strong_errors(scheme, view):
        return Tally()
    with np.errstate(all="ignore"):
        return packed(SIZE, strong_errors(scheme, view, settings.steps))


def size_columns(evidence: Evidence, quantity: str) -> dict[str, object]:
    """Return the leading term of the root mean square error of a quantity at T as details, if it is known.

    Parameters
    ----------
    evidence : Evidence
    quantity : str
        Name of a quantity; only those at T have a leading term.
    """
    if not quantity.endswith(AT_T):
        return {}
    found = evidence.without_paths.read(_read_constant, evidence.view, quantity.removesuffix(AT_T))
    return {} if found is None else found.details


def _read_constant(tally: Tally, view: Problem, component: str) -> Coefficient | None:
    record, rows = unpacked(SIZE, StrongErrors, tally), rows_of_parts(view).get(component)
    if record is None or rows is None or not np.isfinite(record.squares).all():
        return None
    errors = np.sqrt(np.maximum(record.squares[:, rows].sum(axis=1), 0.0))
    # sqrt(e^2 + off) - e, which is sqrt(off) where e vanishes.
    floors = record.floor / (errors + np.sqrt(record.floor))
    size = float(np.sqrt(record.size[rows].sum()))
    found = leading_error(record.h, errors, floors, order_of(record.h, errors, floors, size).order)
    return None if found is None or why_not_resolved(view, float(record.h[-1])) else found


def rows_of_parts(view: Any) -> dict[str, slice]:
    """Return the components of the equation that belong to each named part, and the whole state."""
    parts = view.parts(view.initial(1))
    ends = pairwise([0, *accumulate(map(len, parts.values()))])
    return {**{name: slice(*end) for name, end in zip(parts, ends, strict=True)}, STATE: slice(None)}
