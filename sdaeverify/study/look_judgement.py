"""Judgement of a look in a worker, where code of schemes and problems runs under its limits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..contracts.finding import Verdict
from ..contracts.matching import match
from ..contracts.specs import built
from ..errors import FAULTS, one_line
from ..simulate.ensemble import PROBLEM, Entry, Marker, one_thread
from .judging import CellResult, Known, control_verdicts, judge_cell, without_evidence
from .plan import Cell, Pair, ProblemPlan, entries_of

LATE = "no verdict within {:g} s (--timeout)"
Judged = tuple[CellResult, ...]


@dataclass(frozen=True)
class LookJudgement:
    """Complete input of the judgement of cells of one problem; it can be pickled.

    Attributes
    ----------
    plan : ProblemPlan
        Cells to judge, with the controls of their measures.
    known : mapping of (Scheme, str) to (Settings, CellEvidence)
        Settings and evidence of the cells and of the controls, by scheme and name of the measure.
    """

    plan: ProblemPlan
    known: Mapping[Pair, Known]

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.plan.spec.label

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The schemes of the cells, each with its measures."""
        return entries_of(self.plan.cells)

    def only(self, entries: Sequence[Entry]) -> "LookJudgement":
        """Return the judgement restricted to some schemes, or to some of their measures."""
        kept = {(entry.scheme, measure.name) for entry in entries for measure in entry.measures}
        cells = tuple(cell for cell in self.plan.cells if cell.pair in kept)
        return replace(self, plan=replace(self.plan, cells=cells))

    def without_verdict(self, entry: Entry, why: str) -> Judged:
        """Return the results of the cells of an entry if they could not be judged; `why` is the reason in a line."""
        return tuple(without_evidence(cell, Verdict.ERROR, why) for cell in self.only([entry]).plan.cells)


def look_judgement(plan: ProblemPlan, cells: Sequence[Cell], known: Mapping[Pair, Known]) -> LookJudgement:
    """Return the judgement of some cells of a problem.

    Parameters
    ----------
    plan : ProblemPlan
    cells : sequence of Cell
    known : mapping of (Scheme, str) to (Settings, CellEvidence)
        Of all cells of the problem and its controls.
    """
    measures = {cell.measure.name for cell in cells}
    controls = tuple(each for each in plan.controls if each.control.measure in measures)
    asked = replace(plan, cells=tuple(cells), controls=controls)
    return LookJudgement(asked, {cell.pair: known[cell.pair] for cell in (*asked.cells, *asked.control_cells)})


def judge_look(asked: LookJudgement, marker: Marker) -> list[Judged]:
    """Judge cells, in a worker or in this process.

    Parameters
    ----------
    asked : LookJudgement
    marker : Marker
        Records whose code is running.

    Returns
    -------
    list of tuple of CellResult
        For each entry, the results of its measures.
    """
    with np.errstate(all="ignore"), one_thread():
        try:
            with marker.of(PROBLEM):
                plan = asked.plan if asked.plan.problem is not None else _with_problem(asked.plan)
        except FAULTS as error:
            why = f"problem {asked.label} cannot be built: {one_line(error)}"
            return [asked.without_verdict(entry, why) for entry in asked.entries]
        controls = control_verdicts(plan, asked.known)
        cells = {cell.pair: cell for cell in plan.cells}
        judged = []
        for index, entry in enumerate(asked.entries):
            results = []
            for place, measure in enumerate(entry.measures):
                cell = cells[entry.scheme, measure.name]
                with marker.of(index), marker.measure(place):
                    results.append(judge_cell(plan, cell, *asked.known[cell.pair], controls))
            judged.append(tuple(results))
    return judged


def _with_problem(plan: ProblemPlan) -> ProblemPlan:
    """Return a plan that was sent to this process with its problem, in the form that each scheme solves."""
    problem = built(plan.spec)

    def seen(cell: Cell) -> Cell:
        return replace(cell, seen=match(cell.scheme, problem).problem)

    controls = tuple(
        replace(each, positive=each.positive and seen(each.positive), negative=each.negative and seen(each.negative))
        for each in plan.controls
    )
    return replace(plan, problem=problem, cells=tuple(map(seen, plan.cells)), controls=controls)
