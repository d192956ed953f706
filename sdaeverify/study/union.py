"""Plans of several runs as one: the cells of each, and no others."""

from collections.abc import Iterable
from dataclasses import replace

from .plan import Plan, ProblemPlan


def union(plans: Iterable[Plan]) -> Plan:
    """Return the cells of all plans, each once, those of one problem together.

    Parameters
    ----------
    plans : iterable of Plan

    Returns
    -------
    Plan
    """
    found: dict[str, ProblemPlan] = {}
    for made in (problem for plan in plans for problem in plan.problems):
        before = found.get(made.spec.label)
        found[made.spec.label] = made if before is None else _both(before, made)
    return Plan(tuple(found[label] for label in sorted(found)))


def _both(one: ProblemPlan, other: ProblemPlan) -> ProblemPlan:
    cells = {(cell.scheme.label, cell.measure.name): cell for cell in (*one.cells, *other.cells)}
    controls = {control.control: control for control in (*one.controls, *other.controls)}
    return replace(one, cells=tuple(cells[key] for key in sorted(cells)), controls=tuple(controls.values()))
