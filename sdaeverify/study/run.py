"""Runs blocks on an executor and merges evidence in block order, so that results do not depend on the workers."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from typing import NamedTuple

from ..contracts.settings import SCREENING, Settings
from ..store.store import Store
from ..trees.class_row import ClassRow
from ..workers.executors import Workers
from .blocks import Blocks, Job
from .class_rows import class_rows
from .holm import family_wise
from .judging import CellResult
from .plan import Plan
from .problem_order import longest_first, widest_first
from .problem_run import ProblemRun

HALTED = "no further evidence is in the folder; matrix with the same --out computes it"


class Advanced(NamedTuple):
    """Event: part of the work is done.

    Attributes
    ----------
    done, total : int
        Of a study, the number of finished schemes, over all problems, and the number of all. Each scheme counts
        twice, once for its screening and once for its paths. Of other work, the number of its jobs.
    problem : str
        Label of the problem.
    """

    done: int
    total: int
    problem: str


class Finished(NamedTuple):
    """Event: all cells of a problem are judged."""

    results: tuple[CellResult, ...]


class Compared(NamedTuple):
    """Event: schemes are compared with one reference on part of the paths; see `common_errors`.

    Attributes
    ----------
    done : float
        Number of paths, including the finished fraction of those in progress.
    total : int
        Number of paths.
    problem : str
        Label.
    ended : bool
        Whether a block of paths is finished.
    """

    done: float
    total: int
    problem: str
    ended: bool


Event = Advanced | Finished | Compared


class Study:
    """A plan in progress; finished problems keep their results if the run stops.

    Parameters
    ----------
    plan : Plan
    settings : Settings
    store : Store, optional
        Stored evidence is not computed again; new evidence is stored as soon as it is computed.
    stored_only : bool
        Whether no evidence is computed: a problem is judged as far as there is stored evidence on all its cells.
    orders : bool
        Whether order conditions of the schemes are evaluated, too.

    Attributes
    ----------
    finished : dict of str to tuple of CellResult
        By the label of the problem.
    stopped : str
        Why the other cells were not run.
    class_rows : tuple of ClassRow or None
        Verdicts of order conditions; empty before the end of the run, None if `orders` is false.
    """

    def __init__(
        self,
        plan: Plan,
        settings: Settings,
        store: Store | None = None,
        *,
        stored_only: bool = False,
        orders: bool = False,
    ) -> None:
        self.plan, self.settings, self.store, self.stored_only = plan, settings, store, stored_only
        self.orders = orders
        self.class_rows: tuple[ClassRow, ...] | None = () if orders else None
        self.problems = [ProblemRun(problem, settings) for problem in plan.problems]
        self.finished: dict[str, tuple[CellResult, ...]] = {}
        self.stopped = "not reached"

    @property
    def total(self) -> int:
        """Largest number of blocks, where the screening of each problem counts as one block."""
        return (1 + self.settings.blocks) * sum(problem.open for problem in self.problems)

    def run(self, workers: Workers | Executor | None = None, window: int = 1) -> Iterator[Event]:
        """Find the evidence without paths; then sample and judge each undecided problem, look by look.

        Parameters
        ----------
        workers : Workers or Executor, optional
            Any object with the interface of `concurrent.futures`; blocks run in this process if omitted.
        window : int, optional
            Maximum number of blocks in progress, which bounds the memory of results that wait for their turn.

        Yields
        ------
        Advanced or Finished
        """
        blocks = Blocks(workers, self.store)
        yield from self._finish(problem for problem in self.problems if not problem.open)
        waiting = [problem for problem in self.problems if problem.open]
        yield from self._finish(problem for problem in waiting if not self._goes_on(problem, blocks))
        waiting = [problem for problem in waiting if problem.open]
        yield from self._screen(waiting, blocks, window)
        yield from self._look(waiting, blocks, window)
        if self.orders:
            # In the order of the plan, because the order in which problems finish depends on the workers.
            ended = (self.finished.get(problem.spec.label, ()) for problem in self.plan.problems)
            results = [result for results in ended for result in results]
            self.class_rows = class_rows(results, blocks.workers, self.settings.seed)

    def _screen(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Event]:
        """Find the evidence without paths, beginning with the problems of which there is most."""
        for job, found in blocks.results(deque(_screening(problem) for problem in widest_first(waiting)), window):
            job.problem.absorb(job.task, found)
            job.problem.screened = True
            yield self._advanced(job)

    def _look(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Event]:
        """Sample paths, beginning with the problems that take longest."""
        jobs = deque(job for problem in longest_first(waiting, self.settings) for job in _jobs(problem))
        for job, found in blocks.results(jobs, window):
            job.problem.absorb(job.task, found)
            if job.block == job.last:
                job.problem.judge()
                goes_on = job.problem.open and self._goes_on(job.problem, blocks)
                # Consecutive looks come first; at the end of the queue they would keep a single worker busy.
                jobs.extendleft(reversed([*_jobs(job.problem)] if goes_on else []))
                if not goes_on:
                    yield from self._finish([job.problem])
            yield self._advanced(job)

    def _advanced(self, job: Job) -> Advanced:
        done = sum(self._count_done(problem) for problem in self.problems)
        return Advanced(done, sum(2 * problem.pairs[0] for problem in self.problems), job.task.label)

    def _count_done(self, problem: ProblemRun) -> int:
        schemes, decided = problem.pairs
        if problem.plan.spec.label in self.finished:
            return 2 * schemes
        return schemes + decided if problem.screened else 0

    def results(self) -> list[CellResult]:
        """Return the current results of all cells, with family-wise errors corrected; see `stopped` for the rest."""
        found = [result for problem in self.problems for result in problem.results(self.stopped)]
        return family_wise(found, 1.0 - self.settings.confidence)

    def _goes_on(self, problem: ProblemRun, blocks: Blocks) -> bool:
        """Return whether a problem takes its next look; with `stored_only`, halt cells without stored evidence."""
        if self.store is not None and self.stored_only:
            problem.halt(blocks.lacking(problem.task(), problem.next_blocks), HALTED)
        return problem.open

    def _finish(self, problems: Iterable[ProblemRun]) -> Iterator[Finished]:
        for problem in problems:
            results = problem.results("")
            self.finished[problem.plan.spec.label] = results
            yield Finished(results)


def _screening(problem: ProblemRun) -> Job:
    return Job(problem, problem.task(), SCREENING, SCREENING)


def _jobs(problem: ProblemRun) -> Iterator[Job]:
    task, blocks = problem.task(), problem.blocks
    for block in blocks:
        yield Job(problem, task, block, blocks[-1])
