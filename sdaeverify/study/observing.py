"""What schemes and problems do now, told by worker processes: it decides whether evidence on disk is about them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..contracts.scheme import Scheme
from ..simulate.behaviour import Behaviour
from ..simulate.ensemble import Task, behaviours
from ..workers.calls import Call, Lost, packed, unpacked
from ..workers.isolated import Isolated
from ..workers.limits import StopError, Watchdog

Told = tuple[Behaviour | None, ...]


def behaviours_pickled(task: bytes, mark: Path, timeout: float) -> Told:
    """Tell in a worker process what the schemes of a task do."""
    return behaviours(unpacked(task), Watchdog(mark, timeout))


class Observer:
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
            told = self._told(replace(task, entries=new))
            self.known |= {(label, entry.scheme): one for entry, one in zip(new, told, strict=True)}
        return [self.known[label, entry.scheme] for entry in task.entries]

    def _told(self, task: Task) -> Sequence[Behaviour | None]:
        if self.executor is None:
            return behaviours(task)
        argument = packed(task, f"problem {task.spec.label} or a scheme or measure on it")
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
        rest = self._told(replace(task, entries=(*entries[:lane], *entries[lane + 1 :])))
        return [*rest[:lane], None, *rest[lane:]]
