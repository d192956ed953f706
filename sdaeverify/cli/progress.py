"""Progress on stderr: a bar on a terminal, one line for each finished cell elsewhere."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from ..contracts.finding import Verdict
from ..report.plain import visible
from ..study import Advanced, CellResult, Finished
from .console import errors

Show = Callable[[Advanced | Finished], None]


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


def _lines(event: Advanced | Finished) -> None:
    if isinstance(event, Finished):
        asked = [result for result in event.results if result.cell.verdict is not Verdict.NOT_APPLICABLE]
        for result in asked:
            errors().print(Text(line(result)), soft_wrap=True)


def _bar() -> Progress:
    columns = (
        TextColumn("{task.fields[problem]}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("blocks"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=errors(), transient=True)


def _moved(bar: Progress, total: int) -> Show:
    task = bar.add_task("", total=total, problem="starting")

    def show(event: Advanced | Finished) -> None:
        if isinstance(event, Advanced):
            bar.update(task, completed=event.done, problem=visible(event.problem))

    return show
