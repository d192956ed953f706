"""What judging and writing take of a run's CPU: `python tests/benchmarks/share.py OUT [OPTIONS of matrix]`.

Workers step, probe and pack the evidence; this process judges it, and writes tables and page.
"""

import resource
import sys
import time
from collections import Counter
from collections.abc import Callable
from functools import wraps
from typing import Any

from facade import conclude, judging, run, sequence
from sdaeverify.cli import running

ROOMS = (
    (sequence.ProblemRun, "judge"),
    (sequence.ProblemRun, "judge_screened"),
    (sequence.ProblemRun, "absorb"),
    (judging.ControlVerdicts, "_verdicts"),
    (run, "family_wise"),
    (running, "result_of"),
    (running.Run, "save"),
    (running.Run, "write_page"),
)
# Seconds of each room without those of the rooms that it calls, and of the latter by depth.
spent: Counter[str] = Counter()
within: list[float] = []


def timed(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function whose CPU time is noted."""

    @wraps(function)
    def called(*given: Any, **named: Any) -> Any:
        begun = time.process_time()
        within.append(0.0)
        try:
            return function(*given, **named)
        finally:
            seconds = time.process_time() - begun
            spent[name] += seconds - within.pop()
            if within:
                within[-1] += seconds

    return called


def used(who: int) -> float:
    """Return the CPU seconds of this process or of its children."""
    found = resource.getrusage(who)
    return found.ru_utime + found.ru_stime


def main(out: str, *options: str) -> None:
    """Run the matrix and print the share of each room."""
    for owner, name in ROOMS:
        setattr(owner, name, timed(name, getattr(owner, name)))
    conclude(["matrix", "--fresh", "--progress", "none", "--quiet", "--out", out, *options])
    whole = used(resource.RUSAGE_SELF) + used(resource.RUSAGE_CHILDREN)
    for name, seconds in (*spent.most_common(), ("judging and writing", sum(spent.values())), ("all", whole)):
        print(f"{name:20s} {seconds:8.2f} s {seconds / whole:7.2%}")


if __name__ == "__main__":
    main(*sys.argv[1:])
