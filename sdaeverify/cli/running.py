"""A matrix run: whatever is finished is saved, however the run ends."""

import os
import shlex
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ..api import Result, result_of
from ..contracts.finding import Verdict
from ..contracts.settings import Settings
from ..errors import one_line
from ..registry.load import Registry
from ..report.class_words import class_notes
from ..report.folders import LEVELS, VERDICTS, require_run_folder
from ..report.html import PAGE, remove_page, write_page
from ..report.passports import passports
from ..report.progress import progress
from ..report.sentences import counts_of, ending, lines_of
from ..report.tables.columns import COLUMNS
from ..report.tables.command import records_of
from ..store.store import Store
from ..study import Finished, Plan, Study
from ..study.examination import Work
from ..workers.executors import PROCESSES, LostExecutorError, Workers, crew_of
from ..workers.limits import Limits, available_cores
from ..workers.pool import BLOCKS_A_WORKER
from ..workers.room import NoWorkersError
from .codes_of_runs import code_of_results
from .console import complain, output, output_to_stderr, print_json, print_texts
from .exit_codes import ExitCode

# Evidence is safe as it is: between two savings of the tables lies so many times what one takes. Before the first
# that is taken to be so many seconds a cell.
APART, ROW = 200.0, 5e-5


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
    as_json, quiet : bool
        Whether JSON, or the counts, are all that is said in the end.
    first_only : bool
        Whether the run ends with the first claim that is refuted.
    orders : bool
        Whether schemes are asked for their order conditions.
    examined : sequence of Work
        Examinations beside the study that have come to their end.
    study : Study
    home : Path
        Folder of the process that `folder` is relative to.
    """

    plan: Plan
    settings: Settings
    registry: Registry
    arguments: tuple[str, ...]
    folder: Path
    fresh: bool = False
    stored_only: bool = False
    page: bool = True
    as_json: bool = False
    quiet: bool = False
    first_only: bool = False
    orders: bool = True
    examined: Sequence[Work] = ()
    study: Study = field(init=False)
    home: Path = field(init=False)

    def __post_init__(self) -> None:
        # The code of a plugin that runs in this process may change its folder at any time.
        self.home, store = Path.cwd(), Store(self.folder.absolute(), self.fresh)
        self.study = Study(self.plan, self.settings, store, stored_only=self.stored_only, orders=self.orders)
        # A table without rows, where nobody asks for them: a result would find them when it is saved.
        self.study.class_rows = ()

    @property
    def result(self) -> Result:
        """What is known so far."""
        return result_of(self.study, self.registry, self.arguments, self.examined)

    def save(self) -> Result:
        """Save and return what is known so far."""
        os.chdir(self.home)
        result = self.result
        result.save(self.folder)
        return result

    @property
    def so_far(self) -> str:
        """How much of what can be run is finished, and where it is."""
        every = {problem.spec.label for problem in self.plan.problems if problem.runnable}
        finished = every & self.study.finished.keys()
        return f"{len(finished)} of {len(every)} problems are finished and saved in {self.folder}"

    def stop(self, why: str) -> None:
        """Save what is finished of a run that is ended before its time."""
        self.study.stopped = why
        self.save()
        self.write_page()

    def write_page(self) -> None:
        """Write the page of the folder, or remove that of an earlier run, whose numbers are in no table any more."""
        if self.page:
            with output_to_stderr():
                told = passports(self.plan)
                write_page(self.folder, told)
        else:
            remove_page(self.folder)


def carry_out(run: Run, crew: Workers, kind: str) -> ExitCode:
    """Run the study, save and show its results.

    Parameters
    ----------
    run : Run
    crew : Workers
    kind : str
        Of progress.

    Raises
    ------
    UsageError
        If the report cannot be written.
    """
    require_run_folder(run.folder)
    try:
        result = advance(run, crew, kind)
    except ENDINGS as error:
        halt = halt_of(error)
        run.stop(halt.why)
        complain("" if halt.code is ExitCode.INTERRUPTED else "error", f"{halt.why}; {run.so_far}{halt.advice}")
        return halt.code
    return _finish(run, result)


class Halt(NamedTuple):
    """Why a run was ended before its time, its exit code, and what may help, with a semicolon before it."""

    why: str
    code: ExitCode
    advice: str = ""


# What ends a run, and leaves what is finished of it.
ENDINGS = (KeyboardInterrupt, BrokenExecutor, NoWorkersError, MemoryError)


def halt_of(error: BaseException) -> Halt:
    """Return what one of `ENDINGS` is to the user."""
    if isinstance(error, KeyboardInterrupt):
        return Halt("interrupted", ExitCode.INTERRUPTED)
    if isinstance(error, LostExecutorError | NoWorkersError):
        return Halt(one_line(error), ExitCode.NOT_MEASURED)
    memory = isinstance(error, MemoryError)
    why = "out of memory" if memory else "a worker process died, perhaps for want of memory"
    return Halt(why, ExitCode.NOT_MEASURED, "; try fewer --jobs or a smaller --block")


@contextmanager
def workers(jobs: int, limits: Limits | None, registry: Registry, executor: str = PROCESSES) -> Iterator[Workers]:
    """Give the workers of a run, as `crew_of`, and warn where limits do not hold.

    Parameters
    ----------
    jobs, limits, registry
        As there.
    executor : str
        Its name, perhaps with an address.
    """
    with crew_of(jobs, limits, registry, executor) as crew:
        if executor != PROCESSES and limits is not None:
            complain("warning", f"no limits of time and memory hold on executor {executor}")
        yield crew


def advance(run: Run, crew: Workers, kind: str) -> Result:
    """Run the study, show its progress, save and return what it comes to; see `carry_out` for the parameters.

    Parameters
    ----------
    run : Run
        The study, and where its tables go.
    crew : Workers
        Who computes.
    kind : str
        Of progress: "auto", "plain" or "none".
    """
    due = time.monotonic() + APART * ROW * len(run.plan.cells)
    with output_to_stderr(), progress(kind) as show:
        for event in run.study.run(crew, BLOCKS_A_WORKER * crew.jobs):
            begun = time.monotonic()
            if run.first_only and isinstance(event, Finished) and _has_refuted(event):
                run.study.stopped = "the run ended with the first claim that was refuted (-x)"
                break
            if isinstance(event, Finished) and begun >= due:
                run.save()
                due = time.monotonic() + APART * (time.monotonic() - begun)
            show(event)
    return run.save()


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
    try:
        with crew_of(processes, None, registry) as crew, progress(kind) as show:
            for event in work.run(crew.executor, BLOCKS_A_WORKER * processes):
                show(event)
    except BrokenExecutor:
        complain("error", "a worker process died, perhaps for want of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return ExitCode.OK


def _has_refuted(event: Finished) -> bool:
    return any(finding.verdict is Verdict.REFUTED for result in event.results for finding in result.findings)


def call_report_hooks(run: Run, result: Result) -> None:
    """Let plugins add their reports to the folder of a run, and warn of those that fail."""
    with output_to_stderr():
        failures = run.registry.report(run.folder, result)
    for failure in failures:
        complain("warning", failure)


def _finish(run: Run, result: Result) -> ExitCode:
    run.write_page()
    call_report_hooks(run, result)
    code = code_of_results(result.results)
    if code is ExitCode.NOTHING:
        cell = run.plan.cells[0]
        first = f"{cell.scheme.label} on {cell.spec.label}, {cell.measure.name}: {cell.reason}"
        complain("error", f"nothing to measure: no cell can be run ({first}); --dry-run shows all reasons")
    else:
        _show(run, result, code)
    return code


def _show(run: Run, result: Result, code: ExitCode) -> None:
    console = output()
    if run.as_json:
        print_json(records_of(result.rows.every, result.run))
        return
    sentence = counts_of(result.rows.verdicts, result.rows.absent)
    if run.quiet:
        print_texts(console, lines_of(sentence, console.width))
        return
    notes, plain = [*_notes(run, result), f"exit code {code.value}: {code.words}"], console.options.ascii_only
    print_texts(console, ending(sentence, result.rows.verdicts, notes, console.width, plain=plain))


def _notes(run: Run, result: Result) -> Iterator[str]:
    if run.study.store is not None and run.study.store.telling:
        yield run.study.store.summary()
    yield from class_notes(result.rows.of_classes or ())
    yield from result.run["unseen"]
    page = f"the page is {run.folder / PAGE}; " if run.page else ""
    yield f"{page}{VERDICTS}, {LEVELS}, {COLUMNS} and run.json are in {run.folder}"
    yield f"sdaeverify show {shlex.quote(str(run.folder))} [SCHEME] [PROBLEM] gives the reasons"
