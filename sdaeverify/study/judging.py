"""From the evidence on a problem to the results of its cells."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ..ensemble import LaneEvidence, Task
from ..errors import FAULTS, one_line
from ..matching import match
from ..measure import Evidence, Finding, Judgement, LevelFinding, Verdict
from ..settings import Settings
from ..tally import Tally
from .plan import Cell, ProblemPlan


@dataclass(frozen=True)
class CellResult:
    """What became of a cell.

    Attributes
    ----------
    cell : Cell
    findings : tuple of Finding
        At least one: a cell that was not measured has a single one with the reason.
    levels : tuple of LevelFinding
    health : Tally
    paths : int
    seconds : float
        Time of the scheme on this problem, all its measures together.
    horizon : float
        Final time, in the problem's unit of time.
    """

    cell: Cell
    findings: tuple[Finding, ...]
    levels: tuple[LevelFinding, ...] = ()
    health: Tally = field(default_factory=Tally)
    paths: int = 0
    seconds: float = 0.0
    horizon: float = float("nan")


def unmeasured(cell: Cell, verdict: Verdict, reason: str) -> CellResult:
    """Return the result of a cell without evidence."""
    return CellResult(cell, (Finding(quantity="", verdict=verdict, reason=reason),))


def planned_out(plan: ProblemPlan) -> list[CellResult]:
    """Return the results of the cells that cannot be run."""
    return [unmeasured(cell, cell.verdict, cell.reason) for cell in plan.cells if cell.verdict is not None]


def judge_problem(plan: ProblemPlan, task: Task, lanes: tuple[LaneEvidence, ...]) -> Iterator[CellResult]:
    """Judge every cell of a problem that was run."""
    evidence = {
        (entry.scheme, measure.name): (lane, tally, error)
        for entry, lane in zip(task.entries, lanes, strict=True)
        for measure, tally, error in zip(entry.measures, lane.tallies, lane.errors, strict=True)
    }
    for cell in plan.runnable:
        lane, tally, error = evidence[cell.scheme, cell.measure.name]
        yield unmeasured(cell, Verdict.ERROR, error) if error else _result(plan, cell, task.settings, lane, tally)


def _result(plan: ProblemPlan, cell: Cell, settings: Settings, lane: LaneEvidence, tally: Tally) -> CellResult:
    try:
        # The logarithm of an error that is exactly zero is not a defect; the measures look at what comes out.
        with np.errstate(all="ignore"):
            judgement = _judged(plan, cell, settings, lane, tally)
    except FAULTS as error:
        return unmeasured(cell, Verdict.ERROR, f"measure {cell.measure.name}: {one_line(error)}")
    assert plan.problem is not None
    judgement = judgement._replace(findings=(*judgement.findings, *_unmet(cell, judgement.findings)))
    return CellResult(cell, *judgement, lane.health, settings.paths, lane.seconds, plan.problem.horizon)


def _unmet(cell: Cell, findings: tuple[Finding, ...]) -> Iterator[Finding]:
    """Yield a finding for each quantity that a claim names and the cell does not have."""
    found = {finding.quantity.partition("@")[0] for finding in findings}
    for claim in cell.scheme.promises:
        for quantity in claim.quantities if claim.measure == cell.measure.name else ():
            if quantity not in found:
                reason = f"claimed, but there is no {quantity} here; there are {', '.join(sorted(found))}"
                yield Finding(quantity=quantity, verdict=Verdict.OUT_OF_SCOPE, reason=reason)


def _judged(plan: ProblemPlan, cell: Cell, settings: Settings, lane: LaneEvidence, tally: Tally) -> Judgement:
    assert plan.problem is not None
    view = match(cell.scheme, plan.problem).problem
    assert view is not None
    return cell.measure.judge(Evidence(cell.scheme, plan.problem, view, settings, tally, lane.health))
