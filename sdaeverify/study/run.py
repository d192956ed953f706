"""Blocks over an executor: evidence merged in block order, so that the result does not depend on the workers."""

import pickle
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import NamedTuple

from ..ensemble import LaneEvidence, Task, run_block
from ..errors import FAULTS, UsageError, one_line
from ..settings import Settings
from .families import family_wise
from .judging import CellResult
from .plan import Plan
from .sequence import ProblemRun
from .workers import in_turn

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
        self.problems = [ProblemRun(problem, settings) for problem in plan.problems]
        self.finished: dict[str, tuple[CellResult, ...]] = {}
        self.stopped = "not reached"

    @property
    def total(self) -> int:
        """Largest number of blocks."""
        return self.settings.blocks * sum(problem.open for problem in self.problems)

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced | Finished]:
        """Take look after look: run the blocks of every problem that is not decided, and judge it.

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
        done = 0
        yield from self._finish(problem for problem in self.problems if not problem.open)
        while waiting := [problem for problem in self.problems if problem.open]:
            jobs = [job for problem in waiting for job in _jobs(problem)]
            total = done + len(jobs)
            for job, lanes in _results(executor, window, jobs):
                done += 1
                job.problem.absorb(job.task, lanes)
                yield Advanced(done, total, job.task.spec.label)
                if job.block == job.last:
                    job.problem.judge()
                    yield from self._finish([] if job.problem.open else [job.problem])

    def results(self) -> list[CellResult]:
        """Return the results of all cells as they are, family-wise errors corrected; see `stopped` for the others."""
        found = [result for problem in self.problems for result in problem.results(self.stopped)]
        return family_wise(found, 1.0 - self.settings.confidence)

    def _finish(self, problems: Iterable[ProblemRun]) -> Iterator[Finished]:
        for problem in problems:
            results = problem.results("")
            self.finished[problem.plan.spec.label] = results
            yield Finished(results)


class _Job(NamedTuple):
    """A block of a problem at a look, whose last block is `last`."""

    problem: ProblemRun
    task: Task
    block: int
    last: int


def _jobs(problem: ProblemRun) -> Iterator[_Job]:
    task, blocks = problem.task(), problem.blocks
    for block in blocks:
        yield _Job(problem, task, block, blocks[-1])


def _results(executor: Executor | None, window: int, jobs: Sequence[_Job]) -> Iterator[tuple[_Job, Lanes]]:
    if executor is None:
        yield from in_turn(None, window, ((job, partial(run_block, job.task, job.block)) for job in jobs))
        return
    pickled = {job.task.spec.label: _pickled(job.task) for job in jobs}
    calls = ((job, partial(run_pickled, pickled[job.task.spec.label], job.block)) for job in jobs)
    yield from in_turn(executor, window, calls)


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
