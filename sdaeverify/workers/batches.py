"""Calls about many schemes on a problem at once: who hangs or dies costs its own answer and no other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, Self, TypeVar

from ..simulate.ensemble import NO_MEASURE, PROBLEM, Entry, Marker
from .calls import Call, Function, Lost, RemoteCall, pickle_argument
from .executors import Workers
from .marks import NOBODY, Mark
from .pool import Processes

Answer = TypeVar("Answer")
AGAIN = ", twice"


class Batch(Protocol):
    """Schemes on a problem, with measures."""

    @property
    def entries(self) -> tuple[Entry, ...]:
        """Schemes with the measures that are put to them."""
        ...

    @property
    def label(self) -> str:
        """Label of the problem."""
        ...

    def only(self, entries: Sequence[Entry]) -> Self:
        """Return the batch with some of its entries, or with some of their measures."""
        ...


SomeBatch = TypeVar("SomeBatch", bound=Batch)


class Sent(NamedTuple, Generic[SomeBatch, Answer]):
    """A batch on its way.

    Attributes
    ----------
    batch : Batch
    call : Call or RemoteCall or None
        None where the call is made in this process, when its answers are asked for.
    again : bool
        Whether a process has died of it before.
    """

    batch: SomeBatch
    call: "Call[Sequence[Answer]] | RemoteCall[Sequence[Answer]] | None" = None
    again: bool = False


@dataclass(frozen=True)
class Batches(Generic[SomeBatch, Answer]):
    """Sends batches to workers.

    Attributes
    ----------
    workers : Workers
    function : callable, (Batch, Marker) -> sequence of Answer
        Answers for each entry; at the top level of a module of the framework.
    late : str
        What is said of who takes too long, with a place for the seconds.
    """

    workers: Workers
    function: Function[Sequence[Answer]]
    late: str

    def send(self, batch: SomeBatch, *, again: bool = False) -> Sent[SomeBatch, Answer]:
        """Send a batch."""
        executor = self.workers.executor
        if executor is None:
            return Sent(batch)
        argument = pickle_argument(batch, f"problem {batch.label} or a scheme or measure on it")
        if isinstance(executor, Processes):
            return Sent(batch, Call(executor, self.function, argument), again)
        return Sent(batch, RemoteCall(self.workers, self.function, argument))

    def answers(self, sent: Sent[SomeBatch, Answer]) -> Iterator[tuple[Entry, Answer | Lost]]:
        """Wait for the answers; what a process has died of is asked again, by itself where many were asked.

        Yields
        ------
        entry : Entry
            A scheme, perhaps with some of its measures only.
        answer : Answer or Lost
            Lost is that of a scheme which takes too long, or of which a process has died twice.
        """
        batch, call, again = sent
        found = self.function(batch, Marker()) if call is None else call.outcome()
        if not isinstance(found, Lost):
            yield from zip(batch.entries, found, strict=True)
            return
        given_up, rest = _divide(batch.entries, found, again=again)
        why = self._tell(found, again=again)
        yield from ((entry, found._replace(why=why)) for entry in given_up)
        for each in [self.send(batch.only(entries), again=known) for entries, known in rest]:
            yield from self.answers(each)

    def _tell(self, lost: Lost, *, again: bool) -> str:
        if lost.late:
            assert isinstance(self.workers.executor, Processes)
            return self.late.format(self.workers.executor.limits.timeout)
        return f"{lost.why}{AGAIN if again else ''}"


Entries = tuple[Entry, ...]


def _divide(entries: Entries, lost: Lost, *, again: bool) -> tuple[Entries, list[tuple[Entries, bool]]]:
    """Return which entries are given up, and which are asked again together, and whether they are suspected."""
    mark, final = lost.mark, again or lost.late
    if mark.scheme == NOBODY and len(entries) > 1:
        return (), [((entry,), False) for entry in entries]
    if mark.scheme in {PROBLEM, NOBODY}:
        return (entries, []) if final else ((), [(entries, True)])
    culprit, *rest = _isolate_culprit(entries, mark)
    others = [(tuple(rest), False)] if rest else []
    if lost.late or (again and not rest):
        return (culprit,), others
    return (), [((culprit,), True), *others]


def _isolate_culprit(entries: Entries, mark: Mark) -> list[Entry]:
    """Return the entry whose code ran, with the measure alone if it was one's, and then all that is left."""
    culprit, rest = entries[mark.scheme], [e for index, e in enumerate(entries) if index != mark.scheme]
    if mark.measure == NO_MEASURE or len(culprit.measures) == 1:
        return [culprit, *rest]
    own = culprit.measures[mark.measure]
    others = tuple(measure for measure in culprit.measures if measure is not own)
    return [Entry(culprit.scheme, (own,)), *rest, Entry(culprit.scheme, others)]
