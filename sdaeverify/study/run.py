"""Blocks over an executor: evidence merged in block order, so that the result does not depend on the workers."""

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
    """Some of the work is done.

    Attributes
    ----------
    done, total : int
        Of a study, the schemes on problems that need nothing more, and all, those whose single steps are looked at
        counted as well; of other work, its jobs.
    problem : str
        Label of the problem it belongs to.
    """

    done: int
    total: int
    problem: str


class Finished(NamedTuple):
    """All cells of a problem are judged."""

    results: tuple[CellResult, ...]


class Compared(NamedTuple):
    """Schemes are compared with one reference on some of the paths; see `common_errors`.

    Attributes
    ----------
    done : float
        Number of paths, with the part of those that are under way.
    total : int
        Number of paths.
    problem : str
        Label.
    ended : bool
        Whether a block of paths is at its end.
    """

    done: float
    total: int
    problem: str
    ended: bool


Event = Advanced | Finished | Compared


class Study:
    """A plan under way: what is finished stays, whatever happens to the rest.

    Parameters
    ----------
    plan : Plan
    settings : Settings
    store : Store, optional
        Evidence that is there already is not computed again; what is computed goes there as soon as it is.
    stored_only : bool
        Whether no evidence is computed at all: a problem is judged as far as there is some on all its cells.
    orders : bool
        Whether the schemes are asked for their order conditions, too.

    Attributes
    ----------
    finished : dict of str to tuple of CellResult
        By the label of the problem.
    stopped : str
        Why the other cells were not run.
    class_rows : tuple of ClassRow or None
        What order conditions say; empty before the end of the run, None if nobody asks for them.
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
        """Largest number of blocks, what is found without paths being one of each problem."""
        return (1 + self.settings.blocks) * sum(problem.open for problem in self.problems)

    def run(self, workers: Workers | Executor | None = None, window: int = 1) -> Iterator[Event]:
        """Find all that needs no paths; then take look after look at every problem that is not decided, and judge it.

        Parameters
        ----------
        workers : Workers or Executor, optional
            Anything with the interface of `concurrent.futures`; blocks run in this process if left out.
        window : int, optional
            Blocks in flight: bounds the memory of results that wait for their turn.

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
            # In the order of the plan: problems end in another one with other workers.
            ended = (self.finished.get(problem.spec.label, ()) for problem in self.plan.problems)
            results = [result for results in ended for result in results]
            self.class_rows = class_rows(results, blocks.workers, self.settings.seed)

    def _screen(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Event]:
        """Find what needs no paths, of the problems with the most of it first."""
        for job, found in blocks.results(deque(_screening(problem) for problem in widest_first(waiting)), window):
            job.problem.absorb(job.task, found)
            job.problem.screened = True
            yield self._advanced(job)

    def _look(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Event]:
        """Draw paths, of the problems that take longest first."""
        jobs = deque(job for problem in longest_first(waiting, self.settings) for job in _jobs(problem))
        for job, found in blocks.results(jobs, window):
            job.problem.absorb(job.task, found)
            if job.block == job.last:
                job.problem.judge()
                goes_on = job.problem.open and self._goes_on(job.problem, blocks)
                # Looks in a row are not left to the end, where one worker would be busy with them alone.
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
        """Return the results of all cells as they are, family-wise errors corrected; see `stopped` for the others."""
        found = [result for problem in self.problems for result in problem.results(self.stopped)]
        return family_wise(found, 1.0 - self.settings.confidence)

    def _goes_on(self, problem: ProblemRun, blocks: Blocks) -> bool:
        """Return whether a problem takes its next look; if nothing is computed, cells without evidence are halted."""
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
