"""A run: sealed solvers on problems, tests of their claims on independent runs, and checks."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sdaeverify import Problem, Settings
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Finding, Kind, Opinion, Reason, Verdict
from sdaeverify.studying import ProblemSpec, Registry, Source, one_thread
from sdaeverify_solvers import Asked, PairRun, Row, judge
from sdaeverify_solvers import select_solvers as select_by_label

from .checks import MOTIONS, REPEATS, SEEDS, Answer, check_repeats, check_seeds, statistical
from .contract import Sealed
from .judging import Question, ask, is_decided
from .references import WEAK
from .sample import Budget, Plan, Runner, Sample, check_steps, plans, samples

HOOK = "sdaeverify_sealed"
PROBLEMS = ("gbm", "ou", "harmonic-langevin")
# Claims among which the error probability is shared when a look decides that no further one is needed.
RESERVED = 100


class Cell(NamedTuple):
    """A solver and a problem.

    Attributes
    ----------
    solver : Sealed
    spec : ProblemSpec
        Recipe of the problem.
    problem : Problem
    view : Problem
        As the solver sees it.
    """

    solver: Sealed
    spec: ProblemSpec
    problem: Problem
    view: Problem

    @property
    def label(self) -> str:
        """The label of the problem."""
        return self.spec.label


class Measured(NamedTuple):
    """What came of a cell, fit to be sent from another process.

    Attributes
    ----------
    samples : tuple of Sample
        One for each plan that was carried out.
    answers : tuple of Answer
        Of the checks that need no statistics.
    failed : Opinion or None
        Why nothing is judged.
    seconds : float
    """

    samples: tuple[Sample, ...] = ()
    answers: tuple[Answer, ...] = ()
    failed: Opinion | None = None
    seconds: float = 0.0


def select_solvers(registry: Registry, patterns: Sequence[str]) -> list[Sealed]:
    """Return the solvers that match labels and globs; without patterns all except planted ones and those on request.

    Parameters
    ----------
    registry : Registry
        Registry loaded with `lab`.
    patterns : sequence of str

    Raises
    ------
    UsageError
        If a name is unknown.
    """
    found = select_by_label(registry, HOOK, "sealed solver", patterns)
    return found if patterns else [solver for solver in found if not solver.on_request]


def cells(solvers: Sequence[Sealed], specs: Iterable[ProblemSpec], budget: Budget) -> tuple[list[Cell], list[str]]:
    """Return the pairs that can be measured, and why the others cannot, a line each.

    Parameters
    ----------
    solvers : sequence of Sealed
    specs : iterable of ProblemSpec
        Recipes of the problems.
    budget : Budget
        Its numbers of steps are checked, or those of each solver.
    """
    found, why = list[Cell](), list[str]()
    for spec in specs:
        problem = spec.build()
        for solver in solvers:
            view = solver.view_of(problem)
            reason = why_not(solver, spec, view, budget)
            if reason or view is None:
                why.append(f"{solver.label} on {spec.label}: {reason}")
            else:
                found.append(Cell(solver, spec, problem, view))
    return sorted(found, key=lambda cell: cell.solver.label), why


def why_not(solver: Sealed, spec: ProblemSpec, view: Problem | None, budget: Budget) -> str:
    """Return why a solver cannot be measured on a problem, or an empty string.

    Parameters
    ----------
    solver : Sealed
    spec : ProblemSpec
    view : Problem or None
        As the solver sees it.
    budget : Budget
    """
    if view is None:
        return f"{solver.name} does not solve problems of this form"
    if solver.problems and not {spec.label, spec.name} & set(solver.problems):
        return f"{solver.name} solves {', '.join(solver.problems)} alone"
    check_steps(budget.steps or solver.steps)
    claimed = plans(solver, view, budget.steps or solver.steps)
    return solver.why_not(view) or ("" if claimed else "it claims nothing here of an observable whose mean is known")


class SealedRun(PairRun[Cell, Measured]):
    """Measurement of some cells, complete when `run` is exhausted.

    Parameters
    ----------
    cells : sequence of Cell
    budget : Budget
    confidence : float
        One minus the probability of any false refutation.
    """

    def __init__(self, cells: Sequence[Cell], budget: Budget, confidence: float = Settings().confidence) -> None:
        super().__init__(cells, confidence)
        self.budget = budget

    def task(self, cell: Cell) -> Callable[[], Measured]:
        """Return a function without arguments that measures a cell."""
        return partial(measured, cell.solver, cell.spec, self.budget, self.confidence)

    @property
    def rows(self) -> list[Row]:
        """All rows, cell by cell: verdicts hold for all of their tests together."""
        asked = [(cell, one) for cell, each in self.known for one in questions(cell, each, self.confidence)]
        judged = judge([one for _, one in asked], self.confidence)
        found = [Row(cell, one.measure, finding) for (cell, one), finding in zip(asked, judged, strict=True)]
        return self.in_order([*withhold(found), *(row for cell, each in self.known for row in _further(cell, each))])


def withhold(found: Sequence[Row]) -> list[Row]:
    """Return the rows, without verified findings in cells whose limit or Brownian motion is refuted.

    An error that still falls on its way to a wrong limit seems to have an order.

    Parameters
    ----------
    found : sequence of Row
        Of claims and of checks that are tests.
    """
    against = {id(row.cell): row for row in found if _is_wrong(row)}
    return [
        row._replace(finding=_withheld(row.finding, against[id(row.cell)])) if id(row.cell) in against else row
        for row in found
    ]


def _is_wrong(row: Row) -> bool:
    law = row.measure == MOTIONS or row.finding.reason.has(Kind.WRONG_LIMIT)
    return law and row.finding.verdict is Verdict.REFUTED


def _withheld(finding: Finding, against: Row) -> Finding:
    if finding.verdict is not Verdict.VERIFIED or finding.claim is None:
        return finding
    text = f"but {against.measure} of {against.finding.quantity} is refuted on the same runs"
    reason = finding.reason.then(text, ", ")
    excluded = frozenset({Verdict.VERIFIED})
    return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason, p_verified=1.0, excluded=excluded)


def questions(cell: Cell, each: Measured, confidence: float) -> Iterator[Asked]:
    """Yield the tests of claims on the samples of a cell, and the checks that are tests.

    Parameters
    ----------
    cell : Cell
    each : Measured
        Samples of the cell.
    confidence : float
        Of the intervals.
    """
    if each.failed is None:
        for sample in each.samples:
            question = Question(cell.solver, cell.problem, cell.view, sample, confidence)
            yield from ask(question)
            yield from statistical(question)


def _further(cell: Cell, each: Measured) -> Iterator[Row]:
    """Yield the rows of a cell that are not tests."""
    if each.failed is not None:
        yield Row(cell, WEAK, Finding(quantity="", verdict=each.failed.verdict, reason=each.failed.reason))
    for answer in each.answers:
        verdict = Verdict.REFUTED if answer.failed else Verdict.NOT_APPLICABLE if answer.told else Verdict.VERIFIED
        reason = Reason(answer.failed or answer.told)
        yield Row(cell, answer.check, Finding(quantity="", verdict=verdict, reason=reason, tier=0))


def measured(solver: Sealed, spec: ProblemSpec, budget: Budget, confidence: float) -> Measured:
    """Return the samples of a solver on a problem; an exception of the solver becomes a finding on it.

    Parameters
    ----------
    solver : Sealed
        With its parameters.
    spec : ProblemSpec
        Specification from which any process builds the problem.
    budget : Budget
    confidence : float
        For the end of sampling.
    """
    begun, problem = time.monotonic(), spec.build()
    view = solver.view_of(problem)
    assert view is not None
    cell = Cell(solver, spec, problem, view)
    found, answers = list[Sample](), dict[str, Answer]()
    failed = None
    try:
        with one_thread():
            for plan in plans(solver, view, budget.steps or solver.steps):
                if SEEDS not in answers or not answers[SEEDS].failed:
                    found += _carried_out(cell, plan, budget, answers, confidence)
    except FAULTS as error:
        failed = Opinion(Verdict.ERROR, Reason(one_line(error)))
    if failed is None and any(not np.isfinite(look.means).all() for sample in found for look in sample.looks):
        failed = Opinion(Verdict.DIVERGED, Reason("a mean of the solver's states is not finite"))
    if failed is None and SEEDS in answers and answers[SEEDS].failed:
        failed = Opinion(Verdict.INCONCLUSIVE, Reason(answers[SEEDS].failed))
    return Measured(tuple(found), tuple(answers.values()), failed, time.monotonic() - begun)


def _carried_out(
    cell: Cell, plan: Plan, budget: Budget, answers: dict[str, Answer], confidence: float
) -> list[Sample]:
    """Return the sample of a plan, made look by look until its claims are decided; note what the checks find."""
    runner = Runner(cell.solver, cell.view, Source(budget.seed, cell.label, 0, budget.paths))
    level, last = (1.0 - confidence) / RESERVED, list[Sample]()
    for look, (sample, digests) in enumerate(samples(runner, plan, budget)):
        last = [sample]
        seeds = [seed for step in range(len(plan.h)) for seed in runner.seeds(plan, step, look)]
        finite = bool(np.isfinite(sample.looks[-1].means).all())
        answers[SEEDS] = check_seeds(digests, seeds) if finite else Answer(SEEDS, told="states are not finite")
        if REPEATS not in answers:
            answers[REPEATS] = check_repeats(runner, plan, budget.sizes[0], digests[0])
        question = Question(cell.solver, cell.problem, cell.view, sample, confidence)
        if answers[SEEDS].failed or not finite or is_decided([*ask(question)], level):
            break
    return last
