"""Speed as a ratio: two tasks timed in turn in one run, so that a slow moment of the machine hits both."""

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any

Task = Callable[[], object]


@dataclass(frozen=True)
class Pairs:
    """Seconds of two tasks that ran in turn.

    Attributes
    ----------
    ours, other : tuple of float
    """

    ours: tuple[float, ...]
    other: tuple[float, ...]

    @property
    def cost(self) -> float:
        """Median over the pairs of ours / other."""
        return median(a / b for a, b in zip(self.ours, self.other, strict=True))

    @property
    def speed_up(self) -> float:
        """Median over the pairs of other / ours."""
        return median(b / a for a, b in zip(self.ours, self.other, strict=True))


def timed(task: Task, seconds: list[float]) -> Task:
    """Return the task with its duration added to a list."""

    def run() -> None:
        begun = perf_counter()
        task()
        seconds.append(perf_counter() - begun)

    return run


def run_pairs(benchmark: Any, ours: Task, other: Task, rounds: int) -> Pairs:
    """Time both tasks in turn; the benchmark's own table shows the seconds of ours."""
    mine: list[float] = []
    theirs: list[float] = []
    benchmark.pedantic(timed(ours, mine), setup=timed(other, theirs), rounds=rounds)
    return Pairs(tuple(mine), tuple(theirs))
