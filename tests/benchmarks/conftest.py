"""What the benchmarks share: one core, and a line for each ratio."""

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

Report = Callable[[str, float, str], None]


@pytest.fixture
def one_core() -> Iterator[None]:
    """Keep this process, and the threads a library starts meanwhile, on one core."""
    if not hasattr(os, "sched_setaffinity"):
        pytest.skip("this platform cannot bind a process to a core")
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    yield
    os.sched_setaffinity(0, cores)


@pytest.fixture
def report(benchmark: Any, capsys: pytest.CaptureFixture[str]) -> Report:
    """Return a function (what, ratio, goal) that prints a ratio and puts it into the benchmark's record.

    A goal is shown and never asserted: a ratio still depends on the machine and on who else uses it.
    """

    def write(what: str, ratio: float, goal: str) -> None:
        benchmark.extra_info.update(ratio=ratio, what=what, goal=goal)
        with capsys.disabled():
            print(f"\n{what}: {ratio:.3g} (goal: {goal})")

    return write
