"""Progress on stderr: a bar on a terminal, one line for each finished cell elsewhere."""

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from typing import Any

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from ..contracts.finding import Verdict
from ..registry.load import Registry
from ..report.plain import visible
from ..study import Advanced, CellResult, Event, Finished
from ..workers.pool import BLOCKS_A_WORKER, available_cores, executor_for
from .console import complain, errors
from .exit_codes import ExitCode

Show = Callable[[Event], None]


@contextmanager
def progress(kind: str) -> Iterator[Show]:
    """Give a function that is to be called with every event of a study.

    Parameters
    ----------
    kind : str
        One of `options.KINDS`; ``auto`` is a bar where stderr is a terminal and plain lines elsewhere.
    """
    if kind == "auto" and errors().is_terminal:
        yield from _bar()
    elif kind == "none":
        yield lambda _: None
    else:
        yield _lines


def run_on_workers(work: Any, jobs: int | None, registry: Registry, kind: str) -> ExitCode:
    """Do some work on processes of its own, and show how far it is.

    Parameters
    ----------
    work : Study, Calibration or ExperimentRun
        With its number of jobs, and the events of doing them on workers, so many sent ahead.
    jobs : int or None
        Number of processes at most; all cores by default.
    registry : Registry
        With the plugins that they load.
    kind : str
        Of progress.
    """
    processes = max(1, min(jobs or available_cores(), work.total))
    workers = executor_for(processes, registry.files, modules=registry.modules)
    try:
        with workers as executor, progress(kind) as show:
            for event in work.run(executor, BLOCKS_A_WORKER * processes):
                show(event)
    except BrokenExecutor:
        complain("error", "a worker process died, perhaps for want of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return ExitCode.OK


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


def _bar() -> Iterator[Show]:
    problem = TextColumn("{task.description}", markup=False)
    times = TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(problem, BarColumn(), TaskProgressColumn(), *times, console=errors(), transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(event: Event) -> None:
            if isinstance(event, Advanced):
                bar.update(task, total=event.total, completed=event.done, description=visible(event.problem))

        yield show
