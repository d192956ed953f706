"""Calls about many schemes on a problem at once: who hangs or dies costs its own answer and no other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from ..simulate.ensemble import NO_MEASURE, PROBLEM, Entry, Marker, Task
from .calls import Call, Function, Lost, RemoteCall, pickle_argument
from .executors import Workers
from .marks import NOBODY, Mark
from .pool import Processes

Answer = TypeVar("Answer")
AGAIN = ", twice"


class Sent(NamedTuple, Generic[Answer]):
    """Schemes on a problem that are on their way.

    Attributes
    ----------
    task : Task
    function : callable, (Task, Marker) -> sequence of Answer
        Answers for each entry; at the top level of a module of the framework.
    call : Call or RemoteCall or None
        None where the call is made in this process, when its answers are asked for.
    again : bool
        Whether a process has died of it before.
    """

    task: Task
    function: Function[Sequence[Answer]]
    call: "Call[Sequence[Answer]] | RemoteCall[Sequence[Answer]] | None" = None
    again: bool = False


@dataclass(frozen=True)
class Batches(Generic[Answer]):
    """Sends schemes on a problem to workers.

    Attributes
    ----------
    workers : Workers
    late : str
        What is said of who takes too long, with a place for the seconds.
    """

    workers: Workers
    late: str

    def send(self, task: Task, function: Function[Sequence[Answer]], *, again: bool = False) -> Sent[Answer]:
        """Send the schemes of a task.

        Parameters
        ----------
        task : Task
        function : callable, (Task, Marker) -> sequence of Answer
        again : bool
            Whether a process has died of it before.
        """
        executor = self.workers.executor
        if executor is None:
            return Sent(task, function)
        argument = pickle_argument(task, f"problem {task.label} or a scheme or measure on it")
        if isinstance(executor, Processes):
            return Sent(task, function, Call(executor, function, argument), again)
        return Sent(task, function, RemoteCall(self.workers, function, argument))

    def answers(self, sent: Sent[Answer]) -> Iterator[tuple[Entry, Answer | Lost]]:
        """Wait for the answers; what a process has died of is asked again, by itself where many were asked.

        Yields
        ------
        entry : Entry
            A scheme, perhaps with some of its measures only.
        answer : Answer or Lost
            Lost is that of a scheme which takes too long, or of which a process has died twice.
        """
        task, function, call, again = sent
        found = function(task, Marker()) if call is None else call.outcome()
        if not isinstance(found, Lost):
            yield from zip(task.entries, found, strict=True)
            return
        given_up, rest = _divide(task.entries, found, again=again)
        why = self._tell(found, again=again)
        yield from ((entry, found._replace(why=why)) for entry in given_up)
        for each in [self.send(task.only(entries), function, again=known) for entries, known in rest]:
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
