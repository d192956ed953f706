"""Evidence of blocks of paths: from the store, or simulated by workers."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from math import ceil
from typing import NamedTuple, Protocol, TypeVar

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
from ..store.store import Place, Recalled, Store, keep, with_opened
from ..workers.batches import Batches, Sent
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.pool import Processes

Evidence = tuple[SchemeEvidence, ...]
Part = tuple[Entry, SchemeEvidence]
LATE = "no result within {:g} s on a block of paths (--timeout)"
# Batches for each worker: each finds out about its problem, draws the noise of its block and makes the truth anew, so
# that jobs are cut where few are left, down to a scheme where workers are many; and the schemes at most in a batch.
BATCHES, TOGETHER = 2, 16
# What a worker whose memory is used up may raise outside the code of a scheme.
SHORT = (MemoryError, OSError)


class BehaviourObserver:
    """Tells what the schemes of tasks do on their problems, each asked once: who dies of it has no behaviour.

    Parameters
    ----------
    workers : Workers
        Steps are made in this process if they are none of this machine.
    """

    def __init__(self, workers: Workers) -> None:
        here = workers if isinstance(workers.executor, Processes) else Workers(None, 1)
        self.batches = Batches[Task, Behaviour | None](here, behaviours, LATE)
        self.known: dict[tuple[str, Scheme], Behaviour | None] = {}

    def __call__(self, task: Task) -> list[Behaviour | None]:
        """Return what the schemes of a task do; None where that cannot be told."""
        new = [entry for entry in task.entries if (task.label, entry.scheme) not in self.known]
        for entry, found in self.batches.answers(self.batches.send(task.only(new))) if new else ():
            self.known[task.label, entry.scheme] = None if isinstance(found, Lost) else found
        return [self.known[task.label, entry.scheme] for entry in task.entries]


class BlockBatch(NamedTuple):
    """Schemes that are simulated on a block, and where the evidence on each of them goes.

    Attributes
    ----------
    task : Task
    block : int
    places : tuple of (Place or None)
        None where the evidence is not kept.
    shared : bool
        Whether the worker sees the folder of the run, and keeps the evidence there itself.
    """

    task: Task
    block: int
    places: tuple[Place | None, ...]
    shared: bool = True

    @property
    def entries(self) -> tuple[Entry, ...]:
        """Schemes with their measures."""
        return self.task.entries

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.task.label

    def only(self, entries: Sequence[Entry]) -> "BlockBatch":
        """Return the batch with some of its entries, or with some of their measures."""
        known = {entry.scheme: place for entry, place in zip(self.entries, self.places, strict=True)}
        return self._replace(task=self.task.only(entries), places=tuple(known[entry.scheme] for entry in entries))


def simulate_batch(batch: BlockBatch, marker: Marker) -> Evidence:
    """Simulate a block, in a worker or in this process, and keep its evidence where the folder of the run is seen.

    Parameters
    ----------
    batch : BlockBatch
    marker : Marker
        Is told whose code runs.
    """
    found = _simulate(batch, marker)
    if batch.shared:
        keep(batch.places, batch.entries, found)
    return found


def _simulate(batch: BlockBatch, marker: Marker) -> Evidence:
    task, block, places = batch.task, batch.block, batch.places
    if not any(place is not None for place in places):
        return run_block(task, block, marker) if task.entries else ()
    return with_opened(run_observed(task, block, marker), task)


class Job(Protocol):
    """A block of paths that is to be run."""

    @property
    def task(self) -> Task:
        """What is run on it."""
        ...

    @property
    def block(self) -> int:
        """Index of the block."""
        ...


SomeJob = TypeVar("SomeJob", bound=Job)
SentBatch = Sent[BlockBatch, SchemeEvidence]


class Blocks:
    """Runs blocks on workers.

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
        self.observe = BehaviourObserver(self.workers)
        self.batches = Batches[BlockBatch, SchemeEvidence](self.workers, simulate_batch, LATE)

    def lacking(self, task: Task, blocks: Iterable[int]) -> set[tuple[Scheme, str]]:
        """Return of which scheme and measure not all evidence on some blocks is in the store."""
        return set() if self.store is None else self.store.lacking(task, blocks, self.observe)

    def results(self, jobs: "deque[SomeJob]", window: int) -> "Iterator[tuple[SomeJob, Evidence]]":
        """Take jobs from a queue, which may grow meanwhile, and yield their evidence in their order.

        Parameters
        ----------
        jobs : deque of Job
        window : int
            Blocks under way at most.
        """
        waiting: deque[tuple[SomeJob, list[Recalled], list[SentBatch]]] = deque()
        most = window if self.workers.executor else 1
        while jobs or waiting:
            while jobs and len(waiting) < most:
                job = jobs.popleft()
                waiting.append((job, *self._begin(job, 1 + len(jobs) + len(waiting))))
            job, recalled, sent = waiting.popleft()
            parts = [part for each in sent for part in self._parts(each)]
            yield job, _join(job.task, recalled, parts)

    def _begin(self, job: Job, left: int) -> tuple[list[Recalled], list[SentBatch]]:
        task, block = job.task, job.block
        if self.store is None:
            return [], self._send(BlockBatch(task, block, tuple(None for _ in task.entries), self.shared), left)
        recalled = self.store.recall(task, block, self.observe)
        missing = [r for r in recalled if r.missing]
        entries = [Entry(r.entry.scheme, r.missing) for r in missing]
        batch = BlockBatch(task.only(entries), block, tuple(r.place for r in missing), self.shared)
        return recalled, self._send(batch, left) if missing else []

    def _send(self, batch: BlockBatch, left: int) -> list[SentBatch]:
        """Send a block in batches of some schemes, more where there are more workers for the jobs that are left."""
        entries, jobs = batch.entries, self.workers.jobs
        batches = ceil(BATCHES * jobs / left) if jobs > 1 else 1
        size = min(max(1, ceil(len(entries) / batches)), TOGETHER)
        return [self.batches.send(batch.only(entries[n : n + size])) for n in range(0, len(entries), size)]

    def _parts(self, sent: SentBatch) -> Iterator[Part]:
        """Yield the evidence of a batch; who ran out of memory is tried by itself, in a new process."""
        for entry, found in _ask(self.batches, sent):
            alone = sent.batch.only([entry])
            if found.starved and self.processes is not None:
                yield from self._try_afresh(alone, self.processes)
            else:
                if not self.shared:
                    keep(alone.places, alone.entries, [found])
                yield entry, found

    def _try_afresh(self, batch: BlockBatch, processes: Processes) -> Iterator[Part]:
        with processes.afresh() as fresh:
            batches = replace(self.batches, workers=Workers(fresh, 1))
            found = _ask(batches, batches.send(batch))
        yield from ((entry, _name_limit(evidence, processes.limits.memory)) for entry, evidence in found)


def _ask(batches: Batches[BlockBatch, SchemeEvidence], sent: SentBatch) -> list[Part]:
    """Return the evidence of a batch, or why there is none."""
    try:
        found = list(batches.answers(sent))
    except SHORT as error:
        return [(e, without_evidence(e, f"MemoryError: {error}", starved=True)) for e in sent.batch.entries]
    return [(e, _without(e, known, sent.batch) if isinstance(known, Lost) else known) for e, known in found]


def _without(entry: Entry, lost: Lost, batch: BlockBatch) -> SchemeEvidence:
    where = f"problem {batch.label}: " if lost.mark.scheme == PROBLEM else ""
    return without_evidence(entry, f"{where}{lost.why}")


def _name_limit(found: SchemeEvidence, memory: int) -> SchemeEvidence:
    """Return evidence whose errors for want of memory name the limit of it."""
    room = f"; a worker may have {memory / 2**30:.3g} GiB (--memory)" if memory else ""
    errors = (f"{error}{room}" if index in found.starved else error for index, error in enumerate(found.errors))
    return found._replace(errors=tuple(errors))


def _join(task: Task, recalled: Sequence[Recalled], computed: Sequence[Part]) -> Evidence:
    parts = [*((r.entry, r.lane) for r in recalled if r.lane is not None), *computed]
    if [entry for entry, _ in parts] == list(task.entries):
        return tuple(found for _, found in parts)
    return tuple(join_parts(e, [part for part in parts if part[0].scheme == e.scheme]) for e in task.entries)
