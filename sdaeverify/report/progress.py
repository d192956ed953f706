"""Progress on stderr: a table that fills and a bar on a terminal, one line for each finished cell elsewhere."""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rich.console import Group
from rich.live import Live
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from ..contracts.finding import Verdict
from ..study import Advanced, CellResult, Event, Finished, Screened
from .plain import empty_table, errors, visible
from .sentences import SYMBOLS, mark

# How progress is shown.
KINDS = ("auto", "plain", "none")
# Lines of a terminal that the table leaves free: its head, the bar, and the line of the cursor.
BELOW = 5

Show = Callable[[Event], None]


@contextmanager
def progress(kind: str, total: int) -> Iterator[Show]:
    """Give a function that is to be called with every event of a study.

    Parameters
    ----------
    kind : str
        One of `KINDS`; ``auto`` is a table and a bar where stderr is a terminal and plain lines elsewhere.
    total : int
        Number of blocks.
    """
    if kind == "auto" and errors().is_terminal:
        yield from _live(total)
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


@dataclass
class Board:
    """What is known of each scheme on each problem: first what needs no paths, then what paths add.

    Attributes
    ----------
    worst : dict of str to (dict of str to str)
        By problem and scheme, the worst verdict so far; the problem that was heard of last stands last.
    waiting : dict of str to int
        Cells of a problem that wait for paths.
    """

    worst: dict[str, dict[str, str]] = field(default_factory=dict)
    waiting: dict[str, int] = field(default_factory=dict)

    def hear(self, event: Event) -> None:
        """Take note of what is found."""
        if isinstance(event, Advanced):
            return
        problem = event.problem if isinstance(event, Screened) else event.results[0].cell.spec.label
        found = Counter[tuple[str, str]]()
        for result in event.results:
            found.update((result.cell.scheme.label, str(finding.verdict)) for finding in result.findings)
        schemes = sorted({scheme for scheme, _ in found})
        self.worst.pop(problem, None)
        self.worst[problem] = {name: next(v for v in SYMBOLS if (name, v) in found) for name in schemes}
        self.waiting[problem] = event.waiting if isinstance(event, Screened) else 0

    def table(self, most: int, *, plain: bool = False) -> Table:
        """Return the problems heard of last, at most so many, with a mark for each scheme."""
        schemes = sorted({name for found in self.worst.values() for name in found})
        table = empty_table("problem", f"{len(schemes)} schemes, a mark each", "wait for paths")
        for problem in list(self.worst)[-most:]:
            waiting = self.waiting[problem]
            missing = "not_run" if waiting else "not_applicable"
            verdicts = [self.worst[problem].get(name, missing) for name in schemes]
            marks = Text.assemble(*((mark(verdict, plain=plain), SYMBOLS[verdict][2]) for verdict in verdicts))
            table.add_row(Text(visible(problem)), marks, Text(str(waiting or "")))
        return table


def _live(total: int) -> Iterator[Show]:
    console, board, bar = errors(), Board(), _bar()
    plain, most = console.options.ascii_only, max(1, console.height - BELOW)
    moved = _mover(bar, total)

    def show(event: Event) -> None:
        board.hear(event)
        moved(event)

    def draw() -> Group:
        return Group(*([board.table(most, plain=plain)] if board.worst else []), bar)

    with Live(console=console, transient=True, get_renderable=draw):
        yield show


def _bar() -> Progress:
    columns = (
        TextColumn("{task.fields[problem]}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[told]}", markup=False),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}", markup=False),
    )
    return Progress(*columns, console=errors())


def _mover(bar: Progress, total: int) -> Show:
    task, begun = bar.add_task("", total=None if total else 0, problem="starting", told="", left=""), time.monotonic()

    def show(event: Event) -> None:
        if isinstance(event, Advanced):
            share, left = share_of(event), seconds_left(event, time.monotonic() - begun)
            unit = "" if event.spent is None else " schemes on problems"
            counted = f"{event.done} of {event.total}{unit}"
            waiting = "" if left is None else f"about {_clock(left)} left"
            bar.update(task, total=1.0, completed=share, problem=visible(event.problem), told=counted, left=waiting)

    return show


def share_of(event: Advanced) -> float:
    """Return the part of the work that is done, by its seconds where they are measured."""
    spent, every = (event.done, event.total) if event.spent is None else (event.spent, event.spent + event.left)
    return spent / every if every else 0.0


def seconds_left(event: Advanced, elapsed: float) -> float | None:
    """Return how long a run will take from now on, at the pace it has had; None where that is not known yet."""
    return elapsed * event.left / event.spent if event.spent else None


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}"
