"""Batches of calls on many schemes: a scheme that hangs or kills its worker loses only its own answer."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, Protocol, TypeVar

from ..simulate.ensemble import NO_MEASURE, PROBLEM, Entry, Marker
from .calls import Call, Function, Lost, RemoteCall, pickle_argument
from .executors import Workers
from .marks import NOBODY, Mark
from .pool import Processes

Answer = TypeVar("Answer")
AGAIN = ", twice"


class Asked(Protocol):
    """Argument of a batch call: it can be pickled and restricted to some of its schemes."""

    @property
    def label(self) -> str:
        """Name of the problem, or of another subject of the call, for messages."""

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The schemes, each with all or some of its measures."""

    def only(self, entries: Sequence[Entry]) -> Any:
        """Return a copy restricted to `entries`."""


@dataclass(frozen=True)
class Batch(Generic[Answer]):
    """Schemes on one problem that are sent to a worker in one call.

    Parameters
    ----------
    workers : Workers
    task : Asked
    function : callable, (Asked, Marker) -> sequence of Answer
        Returns one answer per entry; defined at the top level of a module of the framework.
    late : str
        Format string for the reason of a scheme that exceeds its time, with a place for the seconds.
    again : bool
        Whether a worker process has already died of this batch.

    Attributes
    ----------
    call : Call or RemoteCall or None
        None if the call is made in this process, when its answers are requested.
    """

    workers: Workers
    task: Asked
    function: Function[Sequence[Answer]]
    late: str
    again: bool = False
    call: "Call[Sequence[Answer]] | RemoteCall[Sequence[Answer]] | None" = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "call", self._send())

    def _send(self) -> "Call[Sequence[Answer]] | RemoteCall[Sequence[Answer]] | None":
        executor = self.workers.executor
        if executor is None:
            return None
        argument = pickle_argument(self.task, f"problem {self.task.label} or a scheme or measure on it")
        if isinstance(executor, Processes):
            return Call(executor, self.function, argument)
        return RemoteCall(self.workers, self.function, argument)

    def answers(self) -> Iterator[tuple[Entry, Answer | Lost]]:
        """Wait for the answers; if the process died, repeat the call with the suspected scheme by itself.

        Yields
        ------
        entry : Entry
            A scheme, with all or some of its measures.
        answer : Answer or Lost
            Lost for a scheme that exceeds its time or whose worker process has died twice.
        """
        entries = self.task.entries
        found = self.function(self.task, Marker()) if self.call is None else self.call.outcome()
        if not isinstance(found, Lost):
            yield from zip(entries, found, strict=True)
            return
        given_up, rest = _divide(entries, found, again=self.again)
        why = self._reason(found)
        yield from ((entry, found._replace(why=why)) for entry in given_up)
        for each in [replace(self, task=self.task.only(some), again=known) for some, known in rest]:
            yield from each.answers()

    def _reason(self, lost: Lost) -> str:
        if lost.late:
            assert isinstance(self.workers.executor, Processes)
            return self.late.format(self.workers.executor.limits.timeout)
        return f"{lost.why}{AGAIN if self.again else ''}"


Entries = tuple[Entry, ...]


def _divide(entries: Entries, lost: Lost, *, again: bool) -> tuple[Entries, list[tuple[Entries, bool]]]:
    """Return the entries to give up, and groups of entries to repeat, each with whether it is suspected."""
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
    """Return the entry whose code ran, reduced to the running measure if one ran, and then all the rest."""
    culprit, rest = entries[mark.scheme], [e for index, e in enumerate(entries) if index != mark.scheme]
    if mark.measure == NO_MEASURE or len(culprit.measures) == 1:
        return [culprit, *rest]
    own = culprit.measures[mark.measure]
    others = tuple(measure for measure in culprit.measures if measure is not own)
    return [Entry(culprit.scheme, (own,)), *rest, Entry(culprit.scheme, others)]
