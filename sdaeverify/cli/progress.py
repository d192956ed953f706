"""Progress on stderr: a bar on a terminal, one line for each finished cell elsewhere."""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from ..contracts.finding import Verdict
from ..report.plain import visible
from ..study import Advanced, CellResult, Event, Finished
from .console import errors

Show = Callable[[Event], None]


@contextmanager
def progress(kind: str, total: int) -> Iterator[Show]:
    """Give a function that is to be called with every event of a study.

    Parameters
    ----------
    kind : str
        One of `options.KINDS`; ``auto`` is a bar where stderr is a terminal and plain lines elsewhere.
    total : int
        Number of blocks.
    """
    if kind == "auto" and errors().is_terminal:
        with _bar() as bar:
            yield _moved(bar, total)
    elif kind == "none":
        yield lambda _: None
    else:
        yield _lines


def line(result: CellResult) -> str:
    """Return a finished cell in one line: scheme, problem, measure, verdicts, seconds."""
    cell = result.cell
    counts = Counter(finding.verdict for finding in result.findings)
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    return visible(f"{cell.scheme.label}  {cell.spec.label}  {cell.measure.name}  {verdicts}  {result.seconds:.2f} s")


def _lines(event: Event) -> None:
    if isinstance(event, Finished):
        asked = [result for result in event.results if result.cell.verdict is not Verdict.NOT_APPLICABLE]
        for result in asked:
            errors().print(Text(line(result)), soft_wrap=True)


def _bar() -> Progress:
    columns = (
        TextColumn("{task.fields[problem]}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[told]}", markup=False),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}", markup=False),
    )
    return Progress(*columns, console=errors(), transient=True)


def _moved(bar: Progress, total: int) -> Show:
    task, begun = bar.add_task("", total=None if total else 0, problem="starting", told="", left=""), time.monotonic()

    def show(event: Event) -> None:
        if isinstance(event, Advanced):
            share, left = (event.done / max(1, event.total), None)
            if event.pairs:
                share, left = share_of(event), seconds_left(event, time.monotonic() - begun)
            units = (
                (event.decided, event.pairs, "schemes on problems") if event.pairs else (event.done, event.total, "")
            )
            counted = "{} of {} {}".format(*units).rstrip()
            waiting = "" if left is None else f"about {_clock(left)} left"
            bar.update(task, total=1.0, completed=share, problem=visible(event.problem), told=counted, left=waiting)

    return show


def share_of(event: Advanced) -> float:
    """Return the part of the work that is done, by its seconds."""
    every = event.spent + event.left
    return event.spent / every if every else 0.0


def seconds_left(event: Advanced, elapsed: float) -> float | None:
    """Return how long a run will take from now on, at the pace it has had; None where that is not known yet."""
    return elapsed * event.left / event.spent if event.spent else None


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}"
