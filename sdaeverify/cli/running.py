"""A matrix run: whatever is finished is saved, however the run ends."""

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.text import Text

from ..api import Result, result_of
from ..contracts.settings import Settings
from ..registry.load import Registry
from ..report.earlier import Kept
from ..report.files import require_writable
from ..report.html import PAGE, remove_page, write_page
from ..report.passports import passports
from ..report.plain import visible
from ..report.terminal import legend, orders, summary_tables, verdicts_in_words
from ..store import Store
from ..study import CellResult, Finished, Plan, Study
from ..workers.limits import Limits
from ..workers.pool import BLOCKS_A_WORKER, executor_for
from .codes_of_runs import code_of_results
from .console import aside, complain, output
from .exit_codes import ExitCode
from .progress import progress


class Crew(NamedTuple):
    """Who runs blocks.

    Attributes
    ----------
    executor : Executor or None
        None for this process.
    jobs : int
        Number of workers.
    """

    executor: Executor | None
    jobs: int


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
    fresh : bool
        Whether evidence in the folder is left unread.
    stored_only : bool
        Whether nothing is computed.
    page : bool
        Whether a page is written in the end.
    study : Study
    kept : Kept or None
        Rows of earlier runs that were in the folder when the run was first saved.
    """

    plan: Plan
    settings: Settings
    registry: Registry
    arguments: tuple[str, ...]
    folder: Path
    fresh: bool = False
    stored_only: bool = False
    page: bool = True
    study: Study = field(init=False)
    kept: Kept | None = None

    def __post_init__(self) -> None:
        self.study = Study(self.plan, self.settings, Store(self.folder, self.fresh), stored_only=self.stored_only)

    @property
    def result(self) -> Result:
        """What is known so far."""
        return result_of(self.study, self.registry, self.arguments)

    def save(self) -> Result:
        """Save and return what is known so far."""
        result = self.result
        kept = result.save(self.folder)
        self.kept = self.kept or kept
        return result

    @property
    def so_far(self) -> str:
        """How much is finished, and where it is."""
        finished, every = len(self.study.finished), len(self.plan.problems)
        return f"{finished} of {every} problems are finished and saved in {self.folder}"

    def stop(self, why: str) -> None:
        """Save what is finished of a run that is ended before its time."""
        self.study.stopped = why
        self.save()
        self.write_page()

    def write_page(self) -> None:
        """Write the page of the folder, or remove that of an earlier run, whose numbers are in no table any more."""
        if self.page:
            with aside():
                told = passports(self.plan)
            write_page(self.folder, told)
        else:
            remove_page(self.folder)


def carry_out(run: Run, crew: Crew, kind: str) -> ExitCode:
    """Run the study, save and show its results.

    Parameters
    ----------
    run : Run
    crew : Crew
    kind : str
        Of progress.

    Raises
    ------
    UsageError
        If the report cannot be written.
    """
    require_writable(run.folder)
    try:
        result = advance(run, crew, kind)
    except KeyboardInterrupt:
        return _stopped(run, "interrupted", ExitCode.INTERRUPTED)
    except BrokenExecutor:
        return _stopped(run, "a worker process died, perhaps for want of memory", ExitCode.NOT_MEASURED)
    except MemoryError:
        return _stopped(run, "out of memory", ExitCode.NOT_MEASURED)
    return _finished(run, result.results)


@contextmanager
def workers(jobs: int, limits: Limits | None, registry: Registry) -> Iterator[Crew]:
    """Give the workers of a run, as `executor_for`.

    Parameters
    ----------
    jobs : int
        Number of processes.
    limits : Limits or None
        What they are held to.
    registry : Registry
        With the plugin files that they load.
    """
    with executor_for(jobs, registry.files, limits, registry.modules) as executor:
        yield Crew(executor, jobs)


def advance(run: Run, crew: Crew, kind: str) -> Result:
    """Run the study, show its progress, save and return what it comes to; see `carry_out` for the parameters."""
    due = 0.0
    with aside(), progress(kind, run.study.total) as show:
        for event in run.study.run(crew.executor, BLOCKS_A_WORKER * crew.jobs):
            begun = time.monotonic()
            if isinstance(event, Finished) and begun >= due:
                run.save()
                # Evidence is safe as it is: tables take a tenth of the time at most.
                due = time.monotonic() + 10.0 * (time.monotonic() - begun)
            show(event)
    return run.save()


def call_report_hooks(run: Run) -> None:
    """Let plugins add their reports to the folder of a run, and warn of those that fail."""
    with aside():
        failures = run.registry.report(run.folder)
    for failure in failures:
        complain("warning", failure)


def _stopped(run: Run, why: str, code: ExitCode) -> ExitCode:
    run.stop(why)
    if code is ExitCode.INTERRUPTED:
        complain("", f"{why}; {run.so_far}")
    else:
        complain("error", f"{why}; {run.so_far}; try fewer --jobs or a smaller --block")
    return code


def _finished(run: Run, results: Sequence[CellResult]) -> ExitCode:
    run.write_page()
    call_report_hooks(run)
    code = code_of_results(results)
    if code is ExitCode.NOTHING:
        cell = run.plan.cells[0]
        first = f"{cell.scheme.label} on {cell.spec.label}, {cell.measure.name}: {cell.reason}"
        complain("error", f"nothing to measure: no cell can be run ({first}); --dry-run shows all reasons")
    else:
        _show(run, results, code)
    return code


def _of_earlier(run: Run) -> Iterator[str]:
    kept = run.kept
    if kept is not None and kept.verdicts:
        yield f"{len(kept.verdicts)} rows of verdicts on other cells are kept of earlier runs into the same folder"
    if kept is not None and kept.changed:
        yield f"{kept.changed} rows of earlier runs are left out: the code of their cells has changed"


def _show_orders(console: Console, results: Sequence[CellResult], confidence: float) -> None:
    if lines := orders(results):
        title = f"orders in h at grid times, half widths of {confidence:.4g} intervals:"
        for line in (title, *lines):
            console.print(Text(line), soft_wrap=True)
        console.print()


def _show(run: Run, results: Sequence[CellResult], code: ExitCode) -> None:
    console = output()
    plain = console.options.ascii_only
    for table in summary_tables(results, console.width, plain=plain):
        console.print(table)
        console.print()
    console.print(legend(plain=plain))
    console.print()
    _show_orders(console, results, run.settings.confidence)
    for line in verdicts_in_words(results):
        console.print(line, soft_wrap=True)
    if run.study.store is not None and run.study.store.telling:
        console.print(Text(visible(run.study.store.summary())), soft_wrap=True)
    page = f"the page is {run.folder / PAGE}; " if run.page else ""
    files = f"{page}verdicts.csv, levels.csv and run.json are in {run.folder}"
    for told in (*_of_earlier(run), files):
        console.print(Text(visible(told)), soft_wrap=True)
    console.print(f"exit code {code.value}: {code.words}", style="green" if code is ExitCode.OK else "red")
