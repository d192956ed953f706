"""A run of adaptive solvers on problems: tests of claims on paths, and checks."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Claim, Problem, Settings
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Finding, Opinion, Reason, Verdict
from sdaeverify.studying import ProblemSpec, Source, one_thread
from sdaeverify_solvers import Asked, PairRun, Row, judge

from .checks import Answer, check
from .contract import Adaptive
from .judging import LAW, RATE, STEPS, Question, ask
from .path import brownian_path
from .sample import Budget, Runs, Sample, measure, why_not

HOOK, KIND = "sdaeverify_adaptive", "adaptive solver"
# Default problems: multiplicative and additive noise, an area, and an equation without reflection symmetry.
PROBLEMS = ("gbm[a=0.1,b=0.8]", "ou", "heisenberg", "shear")
MEASURES = (RATE, STEPS, LAW)
# Number of paths of the checks, and index of the tolerance for them, at which steps are rejected.
CHECKED, MIDDLE = 20, 2


class Cell(NamedTuple):
    """A solver and a problem.

    Attributes
    ----------
    solver : Adaptive
    spec : ProblemSpec
        Specification of the problem.
    problem : Problem
    """

    solver: Adaptive
    spec: ProblemSpec
    problem: Problem

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.spec.label


class Measured(NamedTuple):
    """Result of a cell in a form that can be pickled, which a problem need not be.

    Attributes
    ----------
    sampled : tuple or None
        Fields of the `Sample` except solver and problem; None if there is no sample.
    failed : Opinion or None
        Why there is no sample.
    answers : tuple of Answer
        Results of the checks.
    seconds : float
        Elapsed time.
    """

    sampled: tuple[Budget, Runs, Array, float, float] | None
    failed: Opinion | None
    answers: tuple[Answer, ...]
    seconds: float = 0.0

    def sample(self, cell: Cell) -> Sample | None:
        """Return the sample of the measured cell."""
        view = cell.solver.view_of(cell.problem)
        return (
            None if self.sampled is None or view is None else Sample(cell.solver, cell.problem, view, *self.sampled)
        )


def cells(solvers: Sequence[Adaptive], specs: Iterable[ProblemSpec]) -> tuple[list[Cell], list[str]]:
    """Return the pairs that can be measured, and a line with the reason for each other pair.

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
                found.append(Cell(solver, spec, problem))
    return sorted(found, key=lambda cell: cell.solver.label), why


def _unclaimed(solver: Adaptive, problem: Problem) -> str:
    return "" if claims_of(solver, problem) else "it has no claims on this problem"


def claims_of(solver: Adaptive, problem: Problem) -> list[Claim]:
    """Return the claims of a solver about its tolerance on a problem.

    Parameters
    ----------
    solver : Adaptive
    problem : Problem
        Problem as registered.
    """
    view = solver.view_of(problem)
    traits = frozenset() if view is None else view.traits
    return [claim for claim in solver.promises if claim.measure in MEASURES and claim.when <= traits]


class AdaptiveRun(PairRun[Cell, Measured]):
    """Measurement of some cells, complete when `run` is exhausted.

    Parameters
    ----------
    pairs : sequence of Cell
    budget : Budget
    confidence : float
        One minus the probability of any false refutation.
    """

    def __init__(self, pairs: Sequence[Cell], budget: Budget, confidence: float = Settings().confidence) -> None:
        super().__init__(pairs, confidence)
        self.budget = budget

    def task(self, cell: Cell) -> Callable[[], Measured]:
        """Return a function without arguments that measures a cell."""
        return partial(measured, cell.solver, cell.spec, self.budget)

    @property
    def rows(self) -> list[Row]:
        """All rows, cell by cell."""
        asked = [(cell, one) for cell, each in self.known if each.failed is None for one in _asked(cell, each)]
        judged = judge([one for _, one in asked], self.confidence)
        found = [Row(cell, one.measure, finding) for (cell, one), finding in zip(asked, judged, strict=True)]
        return self.in_order([*found, *(row for cell, each in self.known for row in _further(cell, each))])


def measured(solver: Adaptive, spec: ProblemSpec, budget: Budget) -> Measured:
    """Measure a solver on a problem; an exception of the solver becomes an opinion.

    Parameters
    ----------
    solver : Adaptive
        Solver with its parameters.
    spec : ProblemSpec
        Specification from which any process can build the problem.
    budget : Budget
        Numbers of paths, tolerances and seed.
    """
    begun = time.monotonic()
    found = _measured(Cell(solver, spec, spec.build()), budget)
    return found._replace(seconds=time.monotonic() - begun)


def _measured(cell: Cell, budget: Budget) -> Measured:
    try:
        with one_thread():
            found = measure(cell.solver, cell.problem, budget, cell.label)
            sampled = found.budget, found.runs, found.truth, found.grid_error, found.grid_bias
            if np.all(np.isfinite(found.runs.ends)):
                return Measured(sampled, None, tuple(_answers(cell, budget)))
    except FAULTS as error:
        return Measured(None, Opinion(Verdict.ERROR, Reason(one_line(error))), ())
    return Measured(sampled, Opinion(Verdict.DIVERGED, Reason("the solver returns values that are not finite")), ())


def _answers(cell: Cell, budget: Budget) -> list[Answer]:
    view = cell.solver.view_of(cell.problem)
    assert view is not None
    path = brownian_path(Source(budget.seed, cell.label, 0, CHECKED), cell.problem.noise_dim, cell.problem.horizon)
    tolerances = budget.tolerances or cell.solver.tolerances
    return check(cell.solver, view, path, tolerances[MIDDLE])


def _asked(cell: Cell, each: Measured) -> Iterator[Asked]:
    if (sample := each.sample(cell)) is not None:
        yield from ask(Question(sample))


def _further(cell: Cell, each: Measured) -> Iterator[Row]:
    """Yield the rows of a cell that do not come from paths: failures and checks."""
    if each.failed is not None:
        yield Row(cell, RATE, Finding(quantity="", verdict=each.failed.verdict, reason=each.failed.reason))
    for answer in each.answers:
        verdict = Verdict.NOT_APPLICABLE if answer.skipped else Verdict.VERIFIED
        verdict = Verdict.REFUTED if answer.failed else verdict
        reason = Reason(answer.failed or answer.skipped)
        yield Row(cell, answer.check, Finding(quantity="", verdict=verdict, reason=reason, tier=0))


def work_of(each: Measured) -> dict[str, object]:
    """Return the work and error at each tolerance of a cell, and the elapsed seconds."""
    return {"work": [*_work(each)], "seconds": round(each.seconds, 2)}


def _work(each: Measured) -> Iterator[Mapping[str, float]]:
    if each.sampled is None:
        return
    budget, runs, truth, *_ = each.sampled
    rms = ((runs.ends - truth) ** 2).sum(axis=1).mean(axis=-1) ** 0.5
    for k, tolerance in enumerate(budget.tolerances):
        counted = {name: float(getattr(runs, name)[k].mean()) for name in ("steps", "rejected", "evaluations")}
        yield {"tolerance": tolerance, "rms": float(rms[k]), **counted}
