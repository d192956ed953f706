"""Runs blocks on an executor and merges evidence in block order, so that results do not depend on the workers."""

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from typing import Any, NamedTuple

from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.stages import SCREENING
from ..simulate.reference import OWN_REFERENCE
from ..store.class_findings import ClassFindings
from ..store.store import Store
from ..workers.executors import Workers
from .blocks import Blocks, Job, Judging
from .class_tests import class_results, class_tests
from .holm import family_wise
from .judging import CellResult
from .plan import Plan, ProblemPlan
from .problem_run import ProblemRun

UNKNOWN = ""
HALTED = "the folder holds no further evidence; matrix with the same --out computes it"


class Advanced(NamedTuple):
    """Event: part of the work is done, of a study possibly the last part of a problem.

    Attributes
    ----------
    done, total : int
        Of a study, the number of finished schemes, over all problems, and the number of all. Each scheme counts
        twice, once for its screening and once for its paths. Of other work, the number of its jobs.
    problem : str
        Label of the problem.
    results : tuple of CellResult
        Results of all cells of a problem that is finished; else empty.
    """

    done: int
    total: int
    problem: str
    results: tuple[CellResult, ...] = ()


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


Event = Advanced | Compared


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
        Whether claims are also tested on classes of equations, by the tests of plugins.
    modified : bool
        Whether the modified equations of all schemes are computed with them; otherwise only those of refuted ones.

    Attributes
    ----------
    finished : dict of str to tuple of CellResult
        By the label of the problem.
    stopped : str
        Why the other cells were not run.
    class_results : tuple of CellResult or None
        Results on classes of equations; empty before the end of the run, None if `orders` is false.

    Raises
    ------
    PluginError
        If `orders` is true, the tests of a plugin are broken, and the environment forbids broken plugins.
    """

    def __init__(
        self,
        plan: Plan,
        settings: Settings,
        store: Store | None = None,
        *,
        stored_only: bool = False,
        orders: bool = False,
        modified: bool = False,
    ) -> None:
        self.plan, self.settings, self.store, self.stored_only = plan, settings, store, stored_only
        self.orders, self.modified = orders, modified
        self.class_results: tuple[CellResult, ...] | None = () if orders else None
        self.class_tests = class_tests() if orders else ()
        self.problems = [ProblemRun(problem, settings) for problem in plan.problems]
        self.finished: dict[str, tuple[CellResult, ...]] = {}
        self.stopped = "not reached"

    @property
    def total(self) -> int:
        """Largest number of blocks, where the screening of each problem counts as one block."""
        return (1 + self.settings.blocks) * sum(problem.open for problem in self.problems)

    def run(self, workers: Workers | Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Find the evidence without paths; then sample and judge each undecided problem, look by look.

        Parameters
        ----------
        workers : Workers or Executor, optional
            Any object with the interface of `concurrent.futures`; blocks run in this process if omitted.
        window : int, optional
            Maximum number of blocks in progress, which bounds the memory of results that wait for their turn.

        Yields
        ------
        Advanced
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
            asked: dict[str, Any] = {"tests": self.class_tests, "modified": self.modified, "stored": self._stored()}
            self.class_results = class_results(results, blocks.workers, self.settings.seed, **asked)

    def _stored(self) -> ClassFindings | None:
        """Return the stored findings on classes, of schemes whose behaviour on all their problems is known."""
        if self.store is None:
            return None
        seen: dict[Scheme, list[str]] = defaultdict(list)
        for problem in self.problems:
            for scheme, known in problem.behaviour.items():
                told = all(behaviour is not None for behaviour, _ in known)
                seen[scheme].append(f"{problem.plan.spec.label}: {sorted(map(repr, known))}" if told else UNKNOWN)
        behaviour = {scheme: "\n".join(told) for scheme, told in seen.items() if UNKNOWN not in told}
        return ClassFindings(self.store, behaviour)

    def _screen(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Advanced]:
        """Find the evidence without paths, beginning with the problems of which there is most."""
        for job in blocks.results(deque(_screening(problem) for problem in widest_first(waiting)), window):
            job.absorb()
            job.problem.screened = True
            yield self._advanced(job.problem)

    def _look(self, waiting: Sequence[ProblemRun], blocks: Blocks, window: int) -> Iterator[Advanced]:
        """Sample paths, beginning with the problems that take longest."""
        jobs = deque[Job | Judging](job for each in longest_first(waiting, self.settings) for job in _jobs(each))
        # What follows a look comes first: at the end of the queue it would keep a single worker busy.
        for job in blocks.results(jobs, window):
            job.absorb()
            if isinstance(job, Judging):
                goes_on = job.problem.open and self._goes_on(job.problem, blocks)
                jobs.extendleft(reversed([*_jobs(job.problem)] if goes_on else []))
                if not goes_on:
                    yield from self._finish([job.problem])
                    continue
            elif job.block == job.last:
                jobs.appendleft(Judging(job.problem, job.problem.judgement()))
            yield self._advanced(job.problem)

    def _advanced(self, problem: ProblemRun, results: tuple[CellResult, ...] = ()) -> Advanced:
        done = sum(self._count_done(each) for each in self.problems)
        total = sum(2 * each.pairs[0] for each in self.problems)
        return Advanced(done, total, problem.plan.spec.label, results)

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

    def _finish(self, problems: Iterable[ProblemRun]) -> Iterator[Advanced]:
        for problem in problems:
            results = problem.results("")
            self.finished[problem.plan.spec.label] = results
            yield self._advanced(problem, results)


def _screening(problem: ProblemRun) -> Job:
    return Job(problem, problem.task(), SCREENING, SCREENING)


def _jobs(problem: ProblemRun) -> Iterator[Job]:
    task, blocks = problem.task(), problem.blocks
    for block in blocks:
        yield Job(problem, task, block, blocks[-1])


# Order in which problems run: the longest first, so that workers finish at about the same time.


def widest_first(problems: Iterable[ProblemRun]) -> list[ProblemRun]:
    """Return problems in the order of their screening, which evaluates single steps."""
    return sorted(problems, key=lambda problem: -_breadth(problem.plan))


def longest_first(problems: Iterable[ProblemRun], settings: Settings) -> list[ProblemRun]:
    """Return problems in the order in which their paths are sampled."""
    return sorted(problems, key=lambda problem: -_weight(problem.plan, settings))


def _weight(plan: ProblemPlan, settings: Settings) -> int:
    """Return the estimated cost of a problem's first paths: the number of steps of all its schemes.

    The cost of a step on so few paths is that of its call, for any problem. If the scheme with shorter steps is the
    reference, that reference makes most of the steps.
    """
    assert plan.problem is not None
    last = settings.levels - 1
    own = OWN_REFERENCE if plan.problem.pathwise is None else 0
    steps = sum(settings.steps) + (settings.coarsest << (last + own) if own else 0)
    return steps * len({cell.scheme for cell in (*plan.runnable, *plan.control_cells)})


def _breadth(plan: ProblemPlan) -> int:
    """Return the estimated cost of a problem's screening: cells times 1 + noise dimension, for cubature nodes."""
    assert plan.problem is not None
    return len(plan.runnable) * (1 + plan.problem.noise_dim)
