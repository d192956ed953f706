"""A run: solvers on problems, what paths say of their claims, and what the checks find."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdaeverify import Problem
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Finding, Opinion, Reason, Verdict
from sdaeverify.studying import ProblemSpec, Source

from .checks import Answer, check
from .contract import Adaptive
from .judging import LAW, RATE, STEPS, Asked, Question, ask, judge
from .path import brownian_path
from .sample import Budget, Sample, measure, why_not

MEASURES = (RATE, STEPS, LAW)
# Paths of the checks, and which of a solver's tolerances they are made with: one at which steps are rejected.
CHECKED, MIDDLE = 20, 2


class Cell(NamedTuple):
    """A solver and a problem.

    Attributes
    ----------
    solver : Adaptive
    label : str
        Of the problem.
    problem : Problem
    """

    solver: Adaptive
    label: str
    problem: Problem


class Row(NamedTuple):
    """A row of the table: what was found of a claim, or by a check.

    Attributes
    ----------
    cell : Cell
    measure : str
        Of the claim, or the name of the check.
    finding : Finding
    """

    cell: Cell
    measure: str
    finding: Finding


@dataclass(frozen=True)
class Measured:
    """What came of a cell: a sample or why there is none, and the answers of the checks."""

    cell: Cell
    sample: Sample | None
    failed: Opinion | None
    answers: tuple[Answer, ...]


def cells(solvers: Sequence[Adaptive], specs: Iterable[ProblemSpec]) -> tuple[list[Cell], list[str]]:
    """Return the pairs that can be measured, and why the others cannot, a line each.

    Parameters
    ----------
    solvers : sequence of Adaptive
    specs : iterable of ProblemSpec
    """
    found, why = list[Cell](), list[str]()
    for spec in specs:
        problem = spec.build()
        for solver in solvers:
            reason = why_not(solver, problem) or _unclaimed(solver, problem)
            if reason:
                why.append(f"{solver.label} on {spec.label}: {reason}")
            else:
                found.append(Cell(solver, spec.label, problem))
    return sorted(found, key=lambda cell: cell.solver.label), why


def _unclaimed(solver: Adaptive, problem: Problem) -> str:
    view = solver.view_of(problem)
    traits = frozenset() if view is None else view.traits
    claimed = any(claim.measure in MEASURES and claim.when <= traits for claim in solver.promises)
    return "" if claimed else "it claims nothing here"


def measured(cell: Cell, budget: Budget) -> Measured:
    """Return what comes of a cell; what a solver raises is an opinion on it."""
    sample, failed = None, None
    try:
        sample = measure(cell.solver, cell.problem, budget, cell.label)
        if not np.all(np.isfinite(sample.runs.ends)):
            failed = Opinion(Verdict.DIVERGED, Reason("the solver returns what is not finite"))
    except FAULTS as error:
        failed = Opinion(Verdict.ERROR, Reason(one_line(error)))
    return Measured(cell, sample, failed, tuple(_answers(cell, budget)) if failed is None else ())


def _answers(cell: Cell, budget: Budget) -> list[Answer]:
    view = cell.solver.view_of(cell.problem)
    assert view is not None
    path = brownian_path(Source(budget.seed, cell.label, 0, CHECKED), cell.problem.noise_dim, cell.problem.horizon)
    tolerances = budget.tolerances or cell.solver.tolerances
    return check(cell.solver, view, path, tolerances[MIDDLE])


def rows(done: Sequence[Measured]) -> list[Row]:
    """Return all rows of a run, cell by cell."""
    asked = [(each.cell, one) for each in done if each.failed is None for one in _asked(each)]
    judged = judge([one for _, one in asked])
    found = [Row(cell, one.measure, finding) for (cell, one), finding in zip(asked, judged, strict=True)]
    found += [row for each in done for row in _further(each)]
    places = [each.cell for each in done]
    return sorted(found, key=lambda row: places.index(row.cell))


def _asked(each: Measured) -> Iterator[Asked]:
    if each.sample is not None:
        yield from ask(Question(each.sample))


def _further(each: Measured) -> Iterator[Row]:
    """Yield the rows of a cell that paths say nothing of."""
    if each.failed is not None:
        yield Row(each.cell, RATE, Finding(quantity="", verdict=each.failed.verdict, reason=each.failed.reason))
    for answer in each.answers:
        verdict = Verdict.NOT_APPLICABLE if answer.skipped else Verdict.VERIFIED
        verdict = Verdict.REFUTED if answer.failed else verdict
        reason = Reason(answer.failed or answer.skipped)
        yield Row(each.cell, answer.check, Finding(quantity="", verdict=verdict, reason=reason, tier=0))
