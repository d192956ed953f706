"""``reproduce``: tables and figures of papers, run again at a chosen budget."""

from concurrent.futures import BrokenExecutor
from contextlib import nullcontext
from math import floor, isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..errors import UsageError
from ..registry import Registry
from ..report.terminal import visible
from ..settings import Settings
from ..study.workers import BLOCKS_A_WORKER, available_cores, worker_pool
from .console import complain, output
from .exit_codes import ExitCode
from .loading import loaded
from .options import once, plugins
from .progress import KINDS, progress

if TYPE_CHECKING:
    from ..experiments import ExperimentRun, Line

FOLDER = Path("reports")
CSV, JSON = "table.csv", "run.json"
WORDS = {
    ExitCode.OK: "every row is run",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.NOT_MEASURED: "a row could not be run",
    ExitCode.INTERRUPTED: "interrupted; the paths that were finished are saved",
}
CODES = "Exit codes: " + "; ".join(f"{code.value} {words}" for code, words in WORDS.items()) + "."
HEADINGS = (
    "problem", "scheme", "h", "mean of", "paper", "here", "exact", "here - exact", "paper - here", "paper - exact",
)  # fmt: skip
BRACKETS = "Brackets hold the standard error in units of the last digit."


@click.command(epilog=CODES, short_help="Run the experiments of papers again.")
@click.argument("name", required=False)
@click.option("--list", "as_list", is_flag=True, help="List the experiments; run nothing.")
@once("--paths", type=int, help="Number of paths of each mean.  [default: the experiment's]")
@click.option("--all", "every", is_flag=True, help="Run the rows that cost most, too.")
@plugins
@once("--seed", type=int, default=Settings().seed, help="Seed of all noise.")
@once("--out", type=click.Path(path_type=Path), help=f"Folder for {CSV} and {JSON}.  [default: {FOLDER}/NAME]")
@once("-j", "--jobs", type=click.IntRange(min=1), help="Worker processes.  [default: all available cores]")
@once("--progress", type=click.Choice(KINDS), default=KINDS[0], help="On stderr: a bar, or nothing.")
@click.pass_context
def reproduce(context: click.Context, /, **options: Any) -> ExitCode:
    """Run the experiment NAME of a paper again, and set its numbers beside the printed and the exact ones.

    Tells where the print agrees with what is found here, and where with the exact value: up to half a unit of the
    last printed digit and four standard errors. A row that disagrees is a result and no failure.
    """
    # Tables need pandas, which takes longer to load than all other commands need in all.
    from ..experiments import ExperimentRun, experiment_plan  # noqa: PLC0415
    from ..report.files import require_writable  # noqa: PLC0415

    registry, name = loaded(options["plugins"]), options["name"]
    if options["as_list"]:
        return _listed(registry, output(unbroken=True))
    if name is None:
        raise UsageError("reproduce expects the name of an experiment; --list shows all")
    plan = experiment_plan(registry, name, paths=options["paths"], seed=options["seed"], every=options["every"])
    folder = options["out"] or FOLDER / name
    require_writable(folder)
    run = ExperimentRun(plan)
    code = _carried_out(run, options["jobs"] or available_cores(), registry, options["progress"])
    return _finished(run, registry, tuple(context.obj), folder, code)


def _listed(registry: Registry, console: Console) -> ExitCode:
    shown = _empty("experiment", "paths", "what it shows", "source")
    for name, entry in registry.experiments.items():
        experiment = entry.experiment
        shown.add_row(name, str(experiment.paths), *map(Text, map(visible, (experiment.title, experiment.source))))
    console.print(shown)
    return ExitCode.OK


def _carried_out(run: "ExperimentRun", jobs: int, registry: Registry, kind: str) -> ExitCode:
    jobs = min(jobs, run.total)
    pool = worker_pool(jobs, registry.files) if jobs > 1 else nullcontext()
    try:
        with pool as executor, progress(kind, run.total) as show:
            for event in run.run(executor, BLOCKS_A_WORKER * jobs):
                show(event)
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    except BrokenExecutor:
        complain("error", "a worker process died, perhaps for want of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return ExitCode.OK


def _finished(
    run: "ExperimentRun", registry: Registry, arguments: tuple[str, ...], folder: Path, code: ExitCode
) -> ExitCode:
    from ..experiments import in_words, lines, table  # noqa: PLC0415
    from ..report.files import write_json, write_table  # noqa: PLC0415
    from ..report.provenance import made_with  # noqa: PLC0415

    found, plan = lines(run), run.plan
    write_table(table(found), folder / CSV)
    about = {"experiment": plan.experiment.name, "source": plan.experiment.source, "paths": plan.paths}
    write_json({**made_with(registry, plan.seed, arguments), **about}, folder / JSON)
    console = output(unbroken=True)
    console.print(_table(found, f"{plan.experiment.source}: {plan.experiment.title}"))
    console.print()
    for text in (BRACKETS, *plan.experiment.notes, *in_words(found), f"{CSV} and {JSON} are in {folder}"):
        console.print(Text(visible(text)), soft_wrap=True)
    if code is ExitCode.OK and any(line.sample.error for line in found):
        code = ExitCode.NOT_MEASURED
    style = "green" if code is ExitCode.OK else "red"
    console.print(f"exit code {code.value}: {WORDS[code]}", style=style, soft_wrap=True)
    return code


def _table(found: "list[Line]", title: str) -> Table:
    shown = _empty(*HEADINGS)
    shown.title, shown.title_justify = Text(visible(title)), "left"
    for line in found:
        shown.add_row(*(Text(visible(text)) for text in _words(line)))
    return shown


def _words(line: "Line") -> tuple[str, ...]:
    row, sample = line.row, line.sample
    return (
        row.problem,
        row.scheme,
        f"{line.h:.4g}",
        row.observable,
        row.printed.digits if row.printed else "",
        _with_error(sample.value, sample.std_error),
        f"{line.exact.value:.10g}" if isfinite(line.exact.value) else "",
        _with_error(line.error, sample.std_error),
        _compared(line.print_to_ours, line.print_and_ours),
        _compared(line.print_to_exact, line.print_and_exact),
    )


def _with_error(value: float, std_error: float) -> str:
    """Return a number up to the second digit of its standard error, 2.0062(12); empty if there is none."""
    if not isfinite(value):
        return ""
    if not 0.0 < std_error < 1.0:
        return f"{value:.4g}" + (f" +- {std_error:.2g}" if std_error else "")
    digits = 1 - floor(log10(std_error))
    return f"{value:.{digits}f}({std_error * 10**digits:.0f})"


def _compared(difference: float, word: str) -> str:
    return f"{difference:+.1e} {word}" if word else ""


def _empty(*headings: str) -> Table:
    shown = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    for heading in headings:
        shown.add_column(Text(heading), overflow="fold")
    return shown
