"""Pairs of a solver and a problem: selection by label, measurement one after the other, and work of a gate.

Adaptive solvers and sealed ones are measured alike. They differ in what a pair is measured for.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from sdaeverify import Settings, UsageError
from sdaeverify.measuring import Finding
from sdaeverify.studying import Advanced, CellResult, Registry, in_turn, parse_label, unknown

PLANTED = "planted-"


class Pair(Protocol):
    """A solver and a problem."""

    @property
    def solver(self) -> Any:
        """The solver, which has a label."""

    @property
    def label(self) -> str:
        """The label of the problem."""


PairT = TypeVar("PairT", bound=Pair)
MeasuredT = TypeVar("MeasuredT")


class Row(NamedTuple):
    """A row of the table: the finding on a claim, or of a check.

    Attributes
    ----------
    cell : Pair
    measure : str
        Measure of the claim, or name of the check.
    finding : Finding
    """

    cell: Pair
    measure: str
    finding: Finding


def select_solvers(registry: Registry, hook: str, kind: str, patterns: Sequence[str]) -> list[Any]:
    """Return the solvers of a hook that match labels and globs, each once; without patterns all except planted ones.

    Parameters
    ----------
    registry : Registry
        Registry loaded with `lab`.
    hook : str
        Name of the hook that returns the solvers.
    kind : str
        Kind of the solvers in words, for messages.
    patterns : sequence of str

    Raises
    ------
    UsageError
        If a name is unknown.
    """
    entries, found = registry.entries.get(hook, {}), dict[str, Any]()
    if not patterns:
        return [entry.thing for name, entry in entries.items() if not name.startswith(PLANTED)]
    for pattern in patterns:
        name, texts = parse_label(pattern)
        names = [known for known in entries if fnmatchcase(known, pattern)] or [name]
        if names == [name] and name not in entries:
            raise UsageError(f"{unknown(kind, name, entries)} (known: {', '.join(entries)})")
        made = (entries[each].make(texts) if texts else entries[each].thing for each in names)
        found |= {solver.label: solver for solver in made}
    return list(found.values())


class PairRun(ABC, Generic[PairT, MeasuredT]):
    """Measurement of some pairs, complete when `run` is exhausted.

    Parameters
    ----------
    pairs : sequence of Pair
    confidence : float
        One minus the probability of any false refutation.
    """

    def __init__(self, pairs: Sequence[PairT], confidence: float = Settings().confidence) -> None:
        self.cells, self.confidence = list(pairs), confidence
        self.done: list[MeasuredT] = []

    @property
    def total(self) -> int:
        """Number of pairs."""
        return len(self.cells)

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Measure all pairs.

        Parameters
        ----------
        executor : Executor, optional
            Executor; by default pairs are measured in this process.
        window : int, optional
            Number of pairs in flight.
        """
        calls = ((cell, self.task(cell)) for cell in self.cells)
        for cell, found in in_turn(executor, window, calls):
            self.done.append(found)
            yield Advanced(len(self.done), self.total, cell.label)

    @abstractmethod
    def task(self, cell: PairT) -> Callable[[], MeasuredT]:
        """Return the measurement of a pair as a function that can be sent to another process."""

    @property
    @abstractmethod
    def rows(self) -> list[Row]:
        """All rows, pair by pair."""

    @property
    def known(self) -> list[tuple[PairT, MeasuredT]]:
        """The measured pairs with their results."""
        return [*zip(self.cells, self.done, strict=True)]

    def in_order(self, rows: Iterable[Row]) -> list[Row]:
        """Sort rows by the places of their pairs."""
        places = {id(cell): place for place, cell in enumerate(self.cells)}
        return sorted(rows, key=lambda row: places[id(row.cell)])


RunT = TypeVar("RunT", bound=PairRun[Any, Any])


@dataclass(frozen=True)
class SolverWork(ABC, Generic[RunT]):
    """Work of an examination.

    Attributes
    ----------
    measuring : PairRun
    notes : tuple of str
        Requested pairs that cannot be measured, with reasons.
    """

    measuring: RunT
    notes: tuple[str, ...]

    @property
    def total(self) -> int:
        """Number of pairs of solver and problem."""
        return self.measuring.total

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Measure all pairs."""
        return self.measuring.run(executor, window)

    @property
    @abstractmethod
    def command(self) -> tuple[str, ...]:
        """Words of the command that measures a pair again."""

    @abstractmethod
    def _results_of(self, cell: Any, done: Any, rows: list[Row]) -> Iterator[CellResult]:
        """Yield the results of a pair, one for each kind of claim."""

    @property
    def results(self) -> list[CellResult]:
        """Results for each solver, problem and kind of claim."""
        rows = self.measuring.rows
        return [
            result
            for cell, done in self.measuring.known
            for result in self._results_of(cell, done, [row for row in rows if row.cell is cell])
        ]
