"""Execution of a matrix run; finished problems are saved however the run ends."""

import os
import shlex
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import click

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
from ..report.sentences import counts_of, ending, wrap_styled
from ..report.tables.columns import COLUMNS
from ..report.tables.command import records_of
from ..store.store import Store
from ..study import Advanced, Plan, Study
from ..study.class_tests import broken_tests
from ..study.examination import Work
from ..workers.executors import PROCESSES, LostExecutorError, Workers, crew_of
from ..workers.limits import Limits, available_cores
from ..workers.pool import BLOCKS_A_WORKER
from ..workers.room import NoWorkersError
from .codes_of_runs import code_of_results
from .console import complain, output, output_to_stderr, print_json, print_texts
from .exit_codes import ExitCode

# Evidence is stored as it is computed, so that tables need to be saved only rarely. APART is the time between two
# saves as a multiple of the time of one, and ROW the assumed seconds per cell of the first save.
APART, ROW = 200.0, 5e-5


@dataclass
class Run:
    """A study in progress and the options of its report.

    Attributes
    ----------
    plan : Plan
    settings : Settings
    registry : Registry
    arguments : tuple of str
        Words of the command line.
    folder : Path
    fresh : bool
        Whether existing evidence in the folder is ignored.
    stored_only : bool
        Whether only stored evidence is used, and no path is computed.
    page : bool
        Whether an HTML page is written at the end.
    as_json, quiet : bool
        Whether the final output is JSON, or only the counts.
    first_only : bool
        Whether the run ends with the first refuted claim.
    orders : bool
        Whether order conditions of the schemes are tested.
    modified : bool
        Whether the modified equations of all schemes are computed with them.
    examined : sequence of Work
        Completed examinations of plugins.
    study : Study
    home : Path
        Working folder to which `folder` is relative.
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
    modified: bool = False
    examined: Sequence[Work] = ()
    study: Study = field(init=False)
    home: Path = field(init=False)

    def __post_init__(self) -> None:
        # Plugin code in this process may change the working folder at any time.
        self.home, store = Path.cwd(), Store(self.folder.absolute(), self.fresh)
        asked = {"stored_only": self.stored_only, "orders": self.orders, "modified": self.modified}
        self.study = Study(self.plan, self.settings, store, **asked)
        for warning in broken_tests() if self.orders else ():
            complain("warning", warning)
        # An empty table if order conditions are not requested; otherwise saving the result would compute them.
        self.study.class_results = ()

    @property
    def result(self) -> Result:
        """Present result, complete or not."""
        return result_of(self.study, self.registry, self.arguments, self.examined)

    def save(self) -> Result:
        """Save and return the present result."""
        os.chdir(self.home)
        result = self.result
        result.save(self.folder)
        return result

    @property
    def so_far(self) -> str:
        """Sentence on the number of finished problems and their folder."""
        every = {problem.spec.label for problem in self.plan.problems if problem.runnable}
        finished = every & self.study.finished.keys()
        return f"{len(finished)} of {len(every)} problems are finished and saved in {self.folder}"

    def stop(self, why: str) -> None:
        """Save the finished part of a run that ends early."""
        self.study.stopped = why
        self.save()
        self.write_page()

    def write_page(self) -> None:
        """Write the page, or remove that of an earlier run, whose numbers no longer match the tables."""
        if self.page:
            with output_to_stderr():
                told = passports(self.plan)
                write_page(self.folder, told)
        else:
            remove_page(self.folder)


def carry_out(run: Run, crew: Workers, kind: str) -> ExitCode:
    """Run the study, save and show its results, and return the exit code.

    Parameters
    ----------
    run : Run
    crew : Workers
    kind : str
        Kind of progress display: "auto", "plain" or "none".

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
    """Reason why a run ended early, its exit code, and advice that begins with a semicolon."""

    why: str
    code: ExitCode
    advice: str = ""


# Exceptions that end a run but keep its finished part.
ENDINGS = (KeyboardInterrupt, BrokenExecutor, NoWorkersError, MemoryError)


def halt_of(error: BaseException) -> Halt:
    """Return the reason, exit code and advice for one of `ENDINGS`."""
    if isinstance(error, KeyboardInterrupt):
        return Halt("interrupted", ExitCode.INTERRUPTED)
    if isinstance(error, LostExecutorError | NoWorkersError):
        return Halt(one_line(error), ExitCode.NOT_MEASURED)
    memory = isinstance(error, MemoryError)
    why = "out of memory" if memory else "a worker process died, possibly out of memory"
    return Halt(why, ExitCode.NOT_MEASURED, "; try fewer --jobs or a smaller --block")


@contextmanager
def workers(jobs: int, limits: Limits | None, registry: Registry, executor: str = PROCESSES) -> Iterator[Workers]:
    """Provide the workers of a run, as `crew_of`, and warn if limits cannot be enforced.

    Parameters
    ----------
    jobs, limits, registry
        See `crew_of`.
    executor : str
        Name of the executor, optionally with an address.
    """
    with crew_of(jobs, limits, registry, executor) as crew:
        if executor != PROCESSES and limits is not None:
            complain("warning", f"executor {executor} does not apply limits of time and memory")
        yield crew


def advance(run: Run, crew: Workers, kind: str) -> Result:
    """Run the study, show its progress, save and return the result; see `carry_out` for the parameters.

    Parameters
    ----------
    run : Run
        The study, and the folder of its tables.
    crew : Workers
        Workers that simulate the blocks.
    kind : str
        Kind of progress display: "auto", "plain" or "none".
    """
    due = time.monotonic() + APART * ROW * len(run.plan.cells)
    with output_to_stderr(), progress(kind) as show:
        for event in run.study.run(crew, BLOCKS_A_WORKER * crew.jobs):
            begun = time.monotonic()
            if run.first_only and _has_refuted(event):
                run.study.stopped = "the run ended at the first refuted claim (-x)"
                break
            if event.results and begun >= due:
                run.save()
                due = time.monotonic() + APART * (time.monotonic() - begun)
            show(event)
    return run.save()


def run_on_workers(work: Any, jobs: int | None, registry: Registry, kind: str) -> ExitCode:
    """Run jobs on separate processes with a progress display, and return the exit code.

    Parameters
    ----------
    work : Study, Calibration or ExperimentRun
        Has the number of jobs as ``total``, and yields events from ``run(executor, ahead)``.
    jobs : int or None
        Largest number of processes; by default the number of available cores.
    registry : Registry
        Registry with the plugins to load in the processes.
    kind : str
        Kind of progress display: "auto", "plain" or "none".
    """
    processes = max(1, min(jobs or available_cores(), work.total))
    try:
        with crew_of(processes, None, registry) as crew, progress(kind) as show:
            for event in work.run(crew.executor, BLOCKS_A_WORKER * processes):
                show(event)
    except BrokenExecutor:
        complain("error", "a worker process died, possibly out of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return ExitCode.OK


def save_results(folder: Path, work: Work, registry: Registry, settings: Settings) -> str:
    """Save the results of a completed examination as a run: tables, ``run.json`` and page, which `show` reads.

    Parameters
    ----------
    folder : Path
        Folder of the run, which need not exist.
    work : Work
    registry : Registry
    settings : Settings
        Seed, sample size and confidence of the results.

    Returns
    -------
    str
        A line that names the page and the command which prints the results.

    Raises
    ------
    UsageError
        If the folder cannot be written into, or belongs to another program.
    """
    arguments = tuple(click.get_current_context().obj or ())
    run = Run(Plan(()), settings, registry, arguments, folder, orders=False, examined=(work,))
    run.save()
    run.write_page()
    shown = f"sdaeverify show {shlex.quote(str(folder))} [SCHEME] [PROBLEM]"
    return f"the page is {folder / PAGE}; {shown} gives the reasons"


def _has_refuted(event: Advanced) -> bool:
    return any(finding.verdict is Verdict.REFUTED for result in event.results for finding in result.findings)


def call_report_hooks(run: Run, result: Result) -> None:
    """Call the report hooks of plugins for the folder of a run, and warn about failures."""
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
        print_texts(console, wrap_styled(sentence, console.width))
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
