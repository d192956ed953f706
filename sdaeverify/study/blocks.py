"""Evidence of a block: from the store or simulated, with the schemes set apart whose worker process died."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, field, replace
from math import ceil, inf
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from ..contracts.scheme import Scheme
from ..simulate.behaviour import Behaviour
from ..simulate.ensemble import Entry, LaneEvidence, Task, behaviours, run_block, without_evidence
from ..simulate.marker import NO_MEASURE, PROBLEM
from ..store.lanes import join_parts
from ..store.store import Place, Recalled, Store, keep, with_opened
from ..workers.calls import Call, Lost, pickle_argument, unpickle_argument
from ..workers.executors import Crew, Remote
from ..workers.isolated import Isolated
from ..workers.limits import NOBODY, Mark, StopError, Watchdog

# What schemes and problems do now, told by worker processes: it decides whether evidence on disk is about them.


Behaviours = tuple[Behaviour | None, ...]


def behaviours_pickled(task: bytes, mark: Path, timeout: float) -> Behaviours:
    """Tell in a worker process what the schemes of a task do.

    Parameters
    ----------
    task : bytes
        A pickled `Task`.
    mark : Path
        File that tells the parent what is being done, in case it takes too long.
    timeout : float
        Seconds for each scheme.
    """
    return behaviours(unpickle_argument(task), Watchdog(mark, timeout))


class BehaviourObserver:
    """Tells what the schemes of tasks do on their problems, each asked once.

    Parameters
    ----------
    executor : Isolated or None
        Steps are made in this process if there is none.
    """

    def __init__(self, executor: Isolated | None) -> None:
        self.executor = executor
        self.known: dict[tuple[str, Scheme], Behaviour | None] = {}

    def __call__(self, task: Task) -> list[Behaviour | None]:
        """Return what the schemes of a task do; None where that cannot be told."""
        label = task.spec.label
        new = tuple(entry for entry in task.entries if (label, entry.scheme) not in self.known)
        if new:
            told = self._observe(replace(task, entries=new))
            self.known |= {(label, entry.scheme): one for entry, one in zip(new, told, strict=True)}
        return [self.known[label, entry.scheme] for entry in task.entries]

    def _observe(self, task: Task) -> Sequence[Behaviour | None]:
        if self.executor is None:
            return behaviours(task)
        argument = pickle_argument(task, f"problem {task.spec.label} or a scheme or measure on it")
        try:
            told = Call(self.executor, behaviours_pickled, argument).outcome()
        except StopError as stop:
            return self._without(task, stop.lane)
        return self._without(task, told.mark.lane) if isinstance(told, Lost) else told

    def _without(self, task: Task, lane: int) -> Sequence[Behaviour | None]:
        """Return what the others do where one scheme hangs or dies of being asked."""
        entries = task.entries
        if lane not in range(len(entries)):
            return [None] * len(entries)
        rest = self._observe(replace(task, entries=(*entries[:lane], *entries[lane + 1 :])))
        return [*rest[:lane], None, *rest[lane:]]


Lanes = tuple[LaneEvidence, ...]
Parts = list[tuple[Entry, LaneEvidence]]
LATE = "no result within {:g} s on a block of paths (--timeout)"
AGAIN = ", twice"
# Pieces for each worker: each finds out about its problem, draws the noise of its block and makes the truth anew, so
# that jobs are cut where few are left, down to a scheme where workers are many; and the schemes at most in a piece.
PIECES, TOGETHER = 2, 16
# What a worker whose memory is used up may raise outside the code of a scheme.
SHORT = (MemoryError, OSError)


class Parcel(NamedTuple):
    """A block to be simulated, and where the evidence on each entry goes."""

    task: Task
    block: int
    places: tuple[Place | None, ...]

    def only(self, entries: Sequence[Entry]) -> "Parcel":
        """Return the parcel with some of its entries, or with some of their measures."""
        known = {entry.scheme: place for entry, place in zip(self.task.entries, self.places, strict=True)}
        places = tuple(known[entry.scheme] for entry in entries)
        return Parcel(replace(self.task, entries=tuple(entries)), self.block, places)


def run_parcel(parcel: Parcel, marker: Watchdog | None = None) -> Lanes:
    """Simulate a block and keep its evidence."""
    lanes = _run(parcel.task, parcel.block, marker, digests=any(place is not None for place in parcel.places))
    keep(parcel.places, parcel.task.entries, lanes)
    return lanes


def _run(task: Task, block: int, marker: Watchdog | None = None, *, digests: bool) -> Lanes:
    lanes = run_block(task, block, marker, digests=digests) if task.entries else ()
    return with_opened(lanes, task) if digests else lanes


def run_pickled(given: bytes, mark: Path | None = None, timeout: float = inf) -> Lanes:
    """Run a parcel in a worker process; memory that is short even for reading it is told as such.

    Parameters
    ----------
    given : bytes
        A pickled `Parcel`.
    mark : Path or None
        File that tells the parent what is being done; None where nobody watches.
    timeout : float
        Seconds for each scheme.
    """
    parcel: Parcel = unpickle_argument(given, MemoryError)
    return run_parcel(parcel, None if mark is None else Watchdog(mark, timeout))


def run_elsewhere(given: bytes) -> Lanes:
    """Simulate a block in a worker that need not see the folder of the run: its evidence is kept by who wants it."""
    task, block, digests = unpickle_argument(given)
    return _run(task, block, digests=digests)


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


class Portion(tuple[tuple[str, float], ...]):
    """A part of a block is computed: labels of schemes, and the seconds of each."""

    __slots__ = ()


class Begun(NamedTuple):
    """A parcel on its way, or without a call where it is run in this process when its turn comes.

    Attributes
    ----------
    parcel : Parcel
    call : Call or Remote, optional
    again : bool
        Whether a process has died of it before.
    """

    parcel: Parcel
    call: Call[Lanes] | Remote[Lanes] | None = None
    again: bool = False


@dataclass
class _Started(Generic[SomeJob]):
    """A job under way: its pieces, and the evidence of those that are done."""

    job: SomeJob
    recalled: list[Recalled]
    begun: list[Begun]
    parts: dict[int, Parts] = field(default_factory=dict)

    @property
    def open(self) -> list[tuple[int, Begun]]:
        """Pieces that are not done, with their numbers."""
        return [(index, one) for index, one in enumerate(self.begun) if index not in self.parts]


class Blocks:
    """Runs blocks over an executor.

    Parameters
    ----------
    executor : Crew, Executor or None
        With an `Isolated` executor, a scheme whose worker dies or takes too long costs its own evidence only.
    store : Store or None
    """

    def __init__(self, executor: Crew | Executor | None, store: Store | None) -> None:
        self.crew = executor if isinstance(executor, Crew) else Crew(executor, 1)
        self.store = store
        self.isolated = self.crew.executor if isinstance(self.crew.executor, Isolated) else None
        self.observe = BehaviourObserver(self.isolated)

    def lacking(self, task: Task, blocks: Iterable[int]) -> set[tuple[Scheme, str]]:
        """Return of which scheme and measure not all evidence on some blocks is in the store."""
        return set() if self.store is None else self.store.lacking(task, blocks, self.observe)

    def results(self, jobs: "deque[SomeJob]", window: int) -> "Iterator[tuple[SomeJob, Lanes | Portion]]":
        """Take jobs from a queue, which may grow meanwhile, and yield their evidence in their order.

        What is computed of a block, perhaps in pieces, is told as soon as it is, and before its evidence.

        Parameters
        ----------
        jobs : deque of Job
        window : int
            Blocks under way at most.
        """
        waiting: deque[_Started[SomeJob]] = deque()
        most = window if self.crew.executor else 1
        while jobs or waiting:
            while jobs and len(waiting) < most:
                job = jobs.popleft()
                waiting.append(_Started(job, *self._begin(job, 1 + len(jobs) + len(waiting))))
            yield from self._tell_done(waiting)
            first = waiting[0]
            if len(first.parts) == len(first.begun):
                waiting.popleft()
                parts = [part for index in range(len(first.begun)) for part in first.parts[index]]
                yield first.job, self._end(first.job.task, first.recalled, parts)
            else:
                calls = [one.call for each in waiting for _, one in each.open if one.call is not None]
                futures: list[Future[Any]] = [call.future for call in calls]
                wait(futures, return_when=FIRST_COMPLETED)

    def _tell_done(self, waiting: "deque[_Started[SomeJob]]") -> "Iterator[tuple[SomeJob, Portion]]":
        """Tell of all pieces that are done, in whatever order; those of this process are done in their order."""
        for each in waiting:
            for index, one in each.open:
                if one.call.future.done() if one.call is not None else each is waiting[0]:
                    found = each.parts[index] = self._parts(one)
                    yield each.job, Portion((entry.scheme.label, lane.seconds) for entry, lane in found)

    def _begin(self, job: Job, left: int) -> tuple[list[Recalled], list[Begun]]:
        task, block = job.task, job.block
        if self.store is None:
            return [], self._send_pieces(Parcel(task, block, tuple(None for _ in task.entries)), left)
        recalled = self.store.recall(task, block, self.observe)
        missing = [r for r in recalled if r.missing]
        entries = tuple(Entry(r.entry.scheme, r.missing) for r in missing)
        parcel = Parcel(replace(task, entries=entries), block, tuple(r.place for r in missing))
        return recalled, self._send_pieces(parcel, left) if missing else []

    def _send_pieces(self, parcel: Parcel, left: int) -> list[Begun]:
        """Send a parcel in pieces of some schemes, more where there are more workers for the jobs that are left."""
        entries, jobs = parcel.task.entries, self.crew.jobs
        pieces = ceil(PIECES * jobs / left) if jobs > 1 else 1
        size = min(max(1, ceil(len(entries) / pieces)), TOGETHER)
        return [self._send(parcel.only(entries[n : n + size])) for n in range(0, len(entries), size)]

    def _end(self, task: Task, recalled: list[Recalled], computed: Parts) -> Lanes:
        parts = [(r.entry, r.lane) for r in recalled if r.lane is not None] + computed
        if [entry for entry, _ in parts] == list(task.entries):
            return tuple(lane for _, lane in parts)
        return tuple(join_parts(e, [part for part in parts if part[0].scheme == e.scheme]) for e in task.entries)

    def _send(self, parcel: Parcel, *, fresh: bool = False, again: bool = False) -> Begun:
        if self.crew.executor is None:
            return Begun(parcel)
        who = f"problem {parcel.task.spec.label} or a scheme or measure on it"
        if self.isolated is None:
            wanted = parcel.task, parcel.block, any(place is not None for place in parcel.places)
            return Begun(parcel, Remote(self.crew, run_elsewhere, pickle_argument(wanted, who)))
        argument = pickle_argument(parcel, who)
        return Begun(parcel, Call(self.isolated, run_pickled, argument, fresh=fresh), again)

    def _parts(self, begun: Begun) -> Parts:
        parcel, call, again = begun
        if isinstance(call, Call):
            return self._collect(parcel, call, again=again)
        if call is None:
            lanes = run_parcel(parcel)
        else:
            lanes = call.outcome()
            keep(parcel.places, parcel.task.entries, lanes)
        return list(zip(parcel.task.entries, lanes, strict=True))

    def _collect(self, parcel: Parcel, call: Call[Lanes], *, again: bool) -> Parts:
        """Return the evidence of a parcel; what died or ran out of memory is tried again where that may help."""
        entries = parcel.task.entries
        try:
            lanes = call.outcome()
        except SHORT as error:
            lanes = tuple(without_evidence(e, f"MemoryError: {error}", starved=True) for e in entries)
        if isinstance(lanes, Lost):
            return self._salvage(parcel, lanes, again=again)
        # Nothing better can be tried for one scheme in a process of its own.
        last = call.fresh and len(entries) == 1
        return [
            part
            for entry, lane in zip(entries, lanes, strict=True)
            for part in self._with_room(parcel.only([entry]), lane, last=last)
        ]

    def _salvage(self, parcel: Parcel, lost: Lost, *, again: bool) -> Parts:
        """Return the evidence of a parcel of which a process died: what may have died by accident is tried again."""
        entries, mark = parcel.task.entries, lost.mark
        pieces = list(entries) if mark.lane in {PROBLEM, NOBODY} else _isolate_culprit(entries, mark)
        if mark.lane == PROBLEM or len(pieces) == 1:
            if again or lost.late:
                return self._dead(parcel, lost, again=again)
            return self._parts(self._send(parcel, again=True))
        if mark.lane == NOBODY:
            return [part for entry in pieces for part in self._parts(self._send(parcel.only([entry]), again=True))]
        alone, rest = parcel.only(pieces[:1]), parcel.only(pieces[1:])
        parts = self._dead(alone, lost, again=again) if lost.late else self._parts(self._send(alone, again=True))
        return parts + self._parts(self._send(rest))

    def _dead(self, parcel: Parcel, lost: Lost, *, again: bool) -> Parts:
        where = f"problem {parcel.task.spec.label}: " if lost.mark.lane == PROBLEM else ""
        why = f"{where}{lost.why(LATE)}{AGAIN if again and not lost.late else ''}"
        return [(entry, without_evidence(entry, why)) for entry in parcel.task.entries]

    def _with_room(self, parcel: Parcel, lane: LaneEvidence, *, last: bool) -> Parts:
        """Return the evidence on one entry; if it ran out of memory, it is tried by itself, in a new process."""
        if not last and lane.starved:
            return self._parts(self._send(parcel, fresh=True))
        (entry,) = parcel.task.entries
        capped = self.isolated is not None and self.isolated.limits.memory
        if not capped:
            return [(entry, lane)]
        room = f"; a worker may have {capped / 2**30:.3g} GiB (--memory)"
        told = (f"{error}{room}" if index in lane.starved else error for index, error in enumerate(lane.errors))
        return [(entry, lane._replace(errors=tuple(told)))]


def _isolate_culprit(entries: tuple[Entry, ...], mark: Mark) -> list[Entry]:
    """Return the entry whose code ran, with the measure alone if it was one's, and then all that is left."""
    culprit, rest = entries[mark.lane], [e for index, e in enumerate(entries) if index != mark.lane]
    if mark.measure == NO_MEASURE or len(culprit.measures) == 1:
        return [culprit, *rest]
    own = culprit.measures[mark.measure]
    others = tuple(measure for measure in culprit.measures if measure is not own)
    return [Entry(culprit.scheme, (own,)), *rest, Entry(culprit.scheme, others)]
