"""Blocks over an executor: evidence merged in block order, so that the result does not depend on the workers."""

import pickle
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from typing import NamedTuple

from ..ensemble import LaneEvidence, Task, run_block
from ..errors import FAULTS, UsageError, one_line
from ..measure import Verdict
from ..settings import Settings
from .judging import CellResult, judge_problem, planned_out, unmeasured
from .plan import Plan, ProblemPlan

Lanes = tuple[LaneEvidence, ...]
UNSENT = "a scheme, problem or measure cannot be read in a"
ELSE = "define it at the top level of a module, or use one job"


class Advanced(NamedTuple):
    """A block is done.

    Attributes
    ----------
    done, total : int
        Blocks of the whole study.
    problem : str
        Label of the problem the block belongs to.
    """

    done: int
    total: int
    problem: str


class Finished(NamedTuple):
    """All cells of a problem are judged."""

    results: tuple[CellResult, ...]


class Study:
    """A plan under way: what is finished stays, whatever happens to the rest.

    Parameters
    ----------
    plan : Plan
    settings : Settings

    Attributes
    ----------
    finished : dict of str to tuple of CellResult
        By the label of the problem.
    stopped : str
        Why the other cells were not run.
    """

    def __init__(self, plan: Plan, settings: Settings) -> None:
        self.plan, self.settings = plan, settings
        self.finished: dict[str, tuple[CellResult, ...]] = {}
        self.stopped = "not reached"

    @property
    def total(self) -> int:
        """Number of blocks."""
        return self.settings.blocks * sum(bool(problem.runnable) for problem in self.plan.problems)

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced | Finished]:
        """Run every block and judge each problem as its last block is done.

        Parameters
        ----------
        executor : Executor, optional
            Anything with the interface of `concurrent.futures`; blocks run in this process if left out.
        window : int, optional
            Blocks in flight: bounds the memory of results that wait for their turn.

        Yields
        ------
        Advanced or Finished
        """
        for problem in self.plan.problems:
            if not problem.runnable:
                yield self._finish(problem, [])
        merged: Lanes | None = None
        for done, (problem, task, block, lanes) in enumerate(self._blocks(executor, window), start=1):
            merged = lanes if block == 0 else _merged(merged, lanes)
            yield Advanced(done, self.total, problem.spec.label)
            if block == self.settings.blocks - 1:
                assert merged is not None
                yield self._finish(problem, list(judge_problem(problem, task, merged)))

    def results(self) -> list[CellResult]:
        """Return the results of all cells; those that were not reached are marked not run."""
        return [result for problem in self.plan.problems for result in self._of(problem)]

    def _of(self, problem: ProblemPlan) -> tuple[CellResult, ...]:
        if problem.spec.label in self.finished:
            return self.finished[problem.spec.label]
        left = [unmeasured(cell, Verdict.NOT_RUN, self.stopped) for cell in problem.runnable]
        return (*left, *planned_out(problem))

    def _finish(self, problem: ProblemPlan, judged: list[CellResult]) -> Finished:
        results = (*judged, *planned_out(problem))
        self.finished[problem.spec.label] = results
        return Finished(results)

    def _blocks(self, executor: Executor | None, window: int) -> Iterator[tuple[ProblemPlan, Task, int, Lanes]]:
        tasks = [(problem, problem.task(self.settings)) for problem in self.plan.problems if problem.runnable]
        jobs = ((problem, task, block) for problem, task in tasks for block in range(self.settings.blocks))
        if executor is None:
            yield from ((problem, task, block, run_block(task, block)) for problem, task, block in jobs)
            return
        pickled = {task.spec.label: _pickled(task) for _, task in tasks}
        waiting: deque[tuple[ProblemPlan, Task, int, Future[Lanes]]] = deque()
        for problem, task, block in jobs:
            waiting.append((problem, task, block, executor.submit(run_pickled, pickled[task.spec.label], block)))
            if len(waiting) >= window:
                yield _collect(waiting)
        while waiting:
            yield _collect(waiting)


def run_pickled(task: bytes, block: int) -> Lanes:
    """Run a block in a worker process.

    Raises
    ------
    UsageError
        If the task cannot be read there: a class or function of it is not at the top level of its module.
    """
    try:
        loaded: Task = pickle.loads(task)
    except FAULTS as error:
        raise UsageError(f"{UNSENT} worker process: {one_line(error)}; {ELSE}") from None
    return run_block(loaded, block)


def _pickled(task: Task) -> bytes:
    try:
        return pickle.dumps(task)
    except FAULTS as error:
        what = f"problem {task.spec.label} or a scheme or measure on it cannot be sent to worker processes"
        raise UsageError(f"{what}: {one_line(error)}; {ELSE}") from error


def _collect(
    waiting: "deque[tuple[ProblemPlan, Task, int, Future[Lanes]]]",
) -> tuple[ProblemPlan, Task, int, Lanes]:
    problem, task, block, future = waiting.popleft()
    return problem, task, block, future.result()


def _merged(before: Lanes | None, lanes: Lanes) -> Lanes:
    assert before is not None
    return tuple(a.merged(b) for a, b in zip(before, lanes, strict=True))
