"""Progress on stderr: a bar on a terminal, otherwise one line for each finished cell."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from ..contracts.finding import Verdict
from ..study import Advanced, CellResult, Compared, Event
from .plain import errors, visible
from .sentences import WORDS

# Kinds of progress display.
KINDS = ("auto", "plain", "none")

Show = Callable[[Event], None]


@contextmanager
def progress(kind: str) -> Iterator[Show]:
    """Yield a function to be called with every event of a study.

    Parameters
    ----------
    kind : str
        Element of `KINDS`; ``auto`` is a bar if stderr is a terminal, and plain lines otherwise.
    """
    if kind == "auto" and errors().is_terminal:
        yield from _bar()
    elif kind == "none":
        yield lambda _: None
    else:
        yield _lines


def line(result: CellResult) -> str:
    """Return a finished cell in one line: scheme, problem, measure, verdicts, seconds."""
    cell = result.cell
    counts = Counter(finding.verdict for finding in result.findings)
    verdicts = ", ".join(f"{count} {WORDS.get(verdict, verdict)}" for verdict, count in counts.items())
    return visible(f"{cell.scheme.label}  {cell.spec.label}  {cell.measure.name}  {verdicts}  {result.seconds:.2f} s")


def _lines(event: Event) -> None:
    if isinstance(event, Advanced):
        asked = [result for result in event.results if result.cell.verdict is not Verdict.NOT_APPLICABLE]
        for result in asked:
            errors().print(Text(line(result)), soft_wrap=True)
    if isinstance(event, Compared) and event.ended:
        errors().print(Text(visible(_comparison(event))), soft_wrap=True)


def _comparison(event: Compared) -> str:
    return f"{event.problem}  compared on {event.done:.0f} of {event.total} paths"


def _bar() -> Iterator[Show]:
    problem = TextColumn("{task.description}", markup=False)
    times = TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(problem, BarColumn(), TaskProgressColumn(), *times, console=errors(), transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(event: Event) -> None:
            if isinstance(event, Advanced):
                bar.update(task, total=event.total, completed=event.done, description=visible(event.problem))
            elif isinstance(event, Compared):
                bar.update(task, total=event.total, completed=event.done, description=visible(_comparison(event)))

        yield show
