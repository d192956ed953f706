"""Evidence of blocks of paths, read from the store or simulated by workers."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property, partial
from math import ceil
from typing import NamedTuple

from ..contracts.scheme import Scheme
from ..simulate.ensemble import (
    PROBLEM,
    Behaviour,
    Entry,
    Marker,
    SchemeEvidence,
    Task,
    run_block,
    without_evidence,
)
from ..store.behaviour import behaviours, run_observed
from ..store.lanes import join_parts
from ..store.store import Places, Recalled, Store, keep, with_opened
from ..workers.batches import Asked, Batch
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.pool import Processes
from .judging import CellResult
from .look_judgement import LATE as LATE_VERDICT
from .look_judgement import LookJudgement, judge_look
from .problem_run import ProblemRun

Evidence = tuple[SchemeEvidence, ...]
Part = tuple[Entry, SchemeEvidence]
SentBlock = Batch[SchemeEvidence]
LATE = "no result within {:g} s on a block of paths (--timeout)"
# Batches per worker, and largest number of schemes in a batch. Each batch builds its problem, draws the noise of its
# block and computes the truth anew. So jobs are split only if few are left, down to single schemes for many workers.
BATCHES, TOGETHER = 2, 16
# Exceptions that a worker out of memory may raise outside the code of a scheme.
SHORT = (MemoryError, OSError)


class BehaviourObserver:
    """Observes the behaviour of the schemes of tasks, once per scheme and problem; None for one that ends its worker.

    Parameters
    ----------
    workers : Workers
        Steps are made in this process if these are not processes of this machine.
    """

    def __init__(self, workers: Workers) -> None:
        self.workers = workers if isinstance(workers.executor, Processes) else Workers(None, 1)
        self.known: dict[tuple[str, Scheme], Behaviour | None] = {}

    def __call__(self, task: Task) -> list[Behaviour | None]:
        """Return the behaviour of each scheme of a task; None where it cannot be determined."""
        new = [entry for entry in task.entries if (task.label, entry.scheme) not in self.known]
        for entry, found in Batch(self.workers, task.only(new), behaviours, LATE).answers() if new else ():
            self.known[task.label, entry.scheme] = None if isinstance(found, Lost) else found
        return [self.known[task.label, entry.scheme] for entry in task.entries]


def simulate_block(task: Task, marker: Marker, block: int, places: Places, *, shared: bool = True) -> Evidence:
    """Simulate a block, in a worker or in this process, and store its evidence if the run's folder is accessible.

    Parameters
    ----------
    task : Task
    marker : Marker
        Records whose code is running.
    block : int
    places : mapping of str to (Place or None)
        Destination of the evidence on a scheme, by its label; None if it is not stored.
    shared : bool
        Whether the worker can access the folder of the run, and stores the evidence there itself.
    """
    if not any(places.values()):
        return run_block(task, block, marker) if task.entries else ()
    found = with_opened(run_observed(task, block, marker), task)
    if shared:
        keep(places, task.entries, found)
    return found


class Job(NamedTuple):
    """A block of a problem, within a look whose last block is `last`, and its evidence once there is any."""

    problem: ProblemRun
    task: Task
    block: int
    last: int
    evidence: Evidence = ()

    def absorb(self) -> None:
        """Merge the evidence into the problem in progress."""
        self.problem.absorb(self.task, self.evidence)


class Judging(NamedTuple):
    """The judgement of a problem at the end of a look, and its results once there are any.

    Attributes
    ----------
    problem : ProblemRun
    task : LookJudgement
    judged, failed : list of CellResult
        Of the cells that are judged, and of those whose judgement ended its process or took too long.
    """

    problem: ProblemRun
    task: LookJudgement
    judged: Sequence[CellResult] = ()
    failed: Sequence[CellResult] = ()

    def absorb(self) -> None:
        """Pass the results to the problem in progress."""
        self.problem.accept(self.judged, self.failed)


class Blocks:
    """Runs blocks on workers, and judges there.

    Parameters
    ----------
    workers : Workers, Executor or None
        With `Processes`, a scheme whose worker dies or takes too long costs its own evidence only.
    store : Store or None
    """

    def __init__(self, workers: Workers | Executor | None, store: Store | None) -> None:
        self.workers = workers if isinstance(workers, Workers) else Workers(workers, 1)
        self.store = store
        executor = self.workers.executor
        self.processes = executor if isinstance(executor, Processes) else None
        self.shared = executor is None or self.processes is not None

    @cached_property
    def observe(self) -> BehaviourObserver:
        """Observer of the behaviour of schemes, by which the store recognises evidence."""
        return BehaviourObserver(self.workers)

    def lacking(self, task: Task, blocks: Iterable[int]) -> set[tuple[Scheme, str]]:
        """Return the pairs of scheme and measure whose evidence on some blocks is not complete in the store."""
        return set() if self.store is None else self.store.lacking(task, blocks, self.observe)

    def results(self, jobs: deque[Job | Judging], window: int) -> Iterator[Job | Judging]:
        """Take jobs from a queue, which may grow meanwhile, and yield them with their results.

        Blocks are in the order of the queue, and judgements come before blocks that were begun earlier.

        Parameters
        ----------
        jobs : deque of Job or Judging
        window : int
            Maximum number of jobs in progress.
        """
        waiting = deque[Callable[[], Job | Judging]]()
        most = window if self.workers.executor else 1
        while jobs or waiting:
            while jobs and len(waiting) < most:
                job = jobs.popleft()
                begun = self._begin(job, 1 + len(jobs) + len(waiting))
                # A judgement does not wait for blocks of other problems, which may take long.
                (waiting.appendleft if isinstance(job, Judging) else waiting.append)(begun)
            yield waiting.popleft()()

    def _begin(self, job: Job | Judging, left: int) -> Callable[[], Job | Judging]:
        """Submit a job, and return the function that waits for it and returns it with its result."""
        if isinstance(job, Judging):
            return partial(_judged, job, Batch(self.workers, job.task, judge_look, LATE_VERDICT))
        recalled = [] if self.store is None else self.store.recall(job.task, job.block, self.observe)
        return partial(self._simulated, job, recalled, self._send(job, recalled, left))

    def _simulated(self, job: Job, recalled: Sequence[Recalled], sent: Iterable[SentBlock]) -> Job:
        parts = [part for each in sent for part in self._parts(each, _places(recalled))]
        return job._replace(evidence=_join(job.task, recalled, parts))

    def _send(self, job: Job, recalled: Sequence[Recalled], left: int) -> list[SentBlock]:
        """Submit a block in batches of schemes; there are more batches if workers outnumber the remaining jobs."""
        missing = [r for r in recalled if r.missing]
        entries = [Entry(r.entry.scheme, r.missing) for r in missing] if self.store else job.task.entries
        batches = ceil(BATCHES * self.workers.jobs / left) if self.workers.jobs > 1 else 1
        size = min(max(1, ceil(len(entries) / batches)), TOGETHER)
        simulate = partial(simulate_block, block=job.block, shared=self.shared)
        return [
            Batch(
                self.workers,
                job.task.only(entries[n : n + size]),
                partial(simulate, places=_places(missing[n : n + size])),
                LATE,
            )
            for n in range(0, len(entries), size)
        ]

    def _parts(self, sent: SentBlock, places: Places) -> Iterator[Part]:
        """Yield the evidence of a batch; a scheme that ran out of memory is run again alone, in a new process."""
        for entry, found in _collect_parts(sent):
            if found.starved and self.processes is not None:
                yield from self._try_afresh(sent, entry, self.processes)
            else:
                if not self.shared:
                    keep(places, [entry], [found])
                yield entry, found

    def _try_afresh(self, sent: SentBlock, entry: Entry, processes: Processes) -> Iterator[Part]:
        with processes.afresh() as fresh:
            found = _collect_parts(
                replace(sent, workers=Workers(fresh, 1), task=sent.task.only([entry]), again=False)
            )
        yield from ((entry, _name_limit(evidence, processes.limits.memory)) for entry, evidence in found)


def _judged(job: Judging, sent: Batch[tuple[CellResult, ...]]) -> Judging:
    judged, failed = list[CellResult](), list[CellResult]()
    try:
        for entry, found in sent.answers():
            if isinstance(found, Lost):
                failed += job.task.without_verdict(entry, found.why)
            else:
                judged += found
    except SHORT as error:
        why = f"MemoryError: {error}"
        judged, failed = [], [each for entry in job.task.entries for each in job.task.without_verdict(entry, why)]
    return job._replace(judged=judged, failed=failed)


def _places(recalled: Iterable[Recalled]) -> Places:
    return {r.entry.scheme.label: r.place for r in recalled}


def _collect_parts(sent: SentBlock) -> list[Part]:
    """Return the evidence of a batch; where it failed, evidence with the error."""
    try:
        found = list(sent.answers())
    except SHORT as error:
        return [(e, without_evidence(e, f"MemoryError: {error}", starved=True)) for e in sent.task.entries]
    return [(e, _failed_evidence(e, known, sent.task) if isinstance(known, Lost) else known) for e, known in found]


def _failed_evidence(entry: Entry, lost: Lost, task: Asked) -> SchemeEvidence:
    where = f"problem {task.label}: " if lost.mark.scheme == PROBLEM else ""
    return without_evidence(entry, f"{where}{lost.why}")


def _name_limit(found: SchemeEvidence, memory: int) -> SchemeEvidence:
    """Return evidence in which errors for lack of memory state the memory limit."""
    room = f"; a worker may have {memory / 2**30:.3g} GiB (--memory)" if memory else ""
    errors = (
        _append_to_first_line(error, room) if index in found.starved else error
        for index, error in enumerate(found.errors)
    )
    return found._replace(errors=tuple(errors))


def _join(task: Task, recalled: Sequence[Recalled], computed: Sequence[Part]) -> Evidence:
    parts = [*((r.entry, r.lane) for r in recalled if r.lane is not None), *computed]
    if [entry for entry, _ in parts] == list(task.entries):
        return tuple(found for _, found in parts)
    return tuple(join_parts(e, [part for part in parts if part[0].scheme == e.scheme]) for e in task.entries)


def _append_to_first_line(error: str, text: str) -> str:
    """Return an error with a text appended to its first line; the following lines are the traceback."""
    line, below, traceback = error.partition("\n")
    return f"{line}{text}{below}{traceback}"
