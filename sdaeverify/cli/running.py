"""A matrix run: whatever is finished is saved, however the run ends."""

from concurrent.futures import BrokenExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.text import Text

from ..api import Result, result_of
from ..registry import Registry
from ..report.files import require_writable
from ..report.terminal import legend, orders, summary_tables, verdicts_in_words, visible
from ..settings import Settings
from ..study import Finished, Plan, Study
from ..study.workers import BLOCKS_A_WORKER, worker_pool
from .console import complain, output
from .exit_codes import ExitCode, code_of_results
from .progress import progress


@dataclass
class Run:
    """A study under way and where its report goes.

    Attributes
    ----------
    plan : Plan
    settings : Settings
    registry : Registry
    arguments : tuple of str
        Words of the command line.
    folder : Path
    study : Study
    """

    plan: Plan
    settings: Settings
    registry: Registry
    arguments: tuple[str, ...]
    folder: Path
    study: Study = field(init=False)

    def __post_init__(self) -> None:
        self.study = Study(self.plan, self.settings)

    @property
    def result(self) -> Result:
        """What is known so far."""
        return result_of(self.study, self.registry, self.arguments)

    @property
    def so_far(self) -> str:
        """How much is finished, and where it is."""
        finished, every = len(self.study.finished), len(self.plan.problems)
        return f"{finished} of {every} problems are finished and saved in {self.folder}"


def carry_out(run: Run, jobs: int, kind: str) -> ExitCode:
    """Run the study, save and show its results.

    Parameters
    ----------
    run : Run
    jobs : int
        Worker processes at most.
    kind : str
        Of progress.

    Raises
    ------
    UsageError
        If the report cannot be written.
    """
    require_writable(run.folder)
    try:
        _advance(run, min(jobs, run.study.total), kind)
    except KeyboardInterrupt:
        return _stopped(run, "interrupted", ExitCode.INTERRUPTED)
    except BrokenExecutor:
        return _stopped(run, "a worker process died, perhaps for want of memory", ExitCode.NOT_MEASURED)
    except MemoryError:
        return _stopped(run, "out of memory", ExitCode.NOT_MEASURED)
    return _finished(run)


def _advance(run: Run, jobs: int, kind: str) -> None:
    pool = worker_pool(jobs, run.registry.files) if jobs > 1 else nullcontext()
    with pool as executor, progress(kind, run.study.total) as show:
        for event in run.study.run(executor, BLOCKS_A_WORKER * jobs):
            if isinstance(event, Finished):
                run.result.save(run.folder)
            show(event)


def _stopped(run: Run, why: str, code: ExitCode) -> ExitCode:
    run.study.stopped = why
    run.result.save(run.folder)
    if code is ExitCode.INTERRUPTED:
        complain("", f"{why}; {run.so_far}")
    else:
        complain("error", f"{why}; {run.so_far}; try fewer --jobs or a smaller --block")
    return code


def _finished(run: Run) -> ExitCode:
    for failure in run.registry.report(run.folder):
        complain("warning", failure)
    code = code_of_results(run.study.results())
    if code is ExitCode.NOTHING:
        cell = run.plan.cells[0]
        first = f"{cell.scheme.label} on {cell.spec.label}, {cell.measure.name}: {cell.reason}"
        complain("error", f"nothing to measure: no cell can be run ({first}); --dry-run shows all reasons")
    else:
        _show(run, code)
    return code


def _show_orders(console: Console, run: Run) -> None:
    if lines := orders(run.study.results()):
        title = f"orders in h at grid times, half widths of {run.settings.confidence:.4g} intervals:"
        for line in (title, *lines):
            console.print(Text(line), soft_wrap=True)
        console.print()


def _show(run: Run, code: ExitCode) -> None:
    console, results = output(), run.study.results()
    plain = console.options.ascii_only
    for table in summary_tables(results, console.width, plain=plain):
        console.print(table)
        console.print()
    console.print(legend(plain=plain))
    console.print()
    _show_orders(console, run)
    for line in verdicts_in_words(results):
        console.print(line, soft_wrap=True)
    files = f"verdicts.csv, levels.csv and run.json are in {run.folder}"
    console.print(Text(visible(files)), soft_wrap=True)
    console.print(f"exit code {code.value}: {code.words}", style="green" if code is ExitCode.OK else "red")
