"""``reproduce``: tables and figures of papers, run again at a chosen budget."""

from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from itertools import compress
from math import floor, isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...contracts.specs import unknown
from ...errors import UsageError
from ...registry.load import Registry
from ...report.terminal import empty_table, visible
from ...workers.pool import BLOCKS_A_WORKER, available_cores, executor_for
from ..console import complain, output
from ..exit_codes import ExitCode, codes_in_words
from ..loading import loaded
from ..options import jobs, once, plugins, progress_bar, seed
from ..progress import progress

if TYPE_CHECKING:
    from ...lab.experiments import ExperimentRun, Line, Order

FOLDER = Path("reports")
CSV, JSON = "table.csv", "run.json"
WORDS = {
    ExitCode.OK: "every row is run",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.NOT_MEASURED: "a row could not be run",
    ExitCode.INTERRUPTED: "interrupted; the paths that were finished are saved",
}
HEADINGS = (
    "problem", "scheme", "h", "t", "mean of", "paper", "here", "effective paths", "of the scheme", "here - scheme",
    "exact", "here - exact", "paper - here", "paper - exact",
)  # fmt: skip
BRACKETS = "Brackets hold the standard error in units of the last digit."
# A mean is said to rest on few paths from this part of them down.
FEW = 0.1
EFFECTIVE = "Effective paths, (sum y)^2/sum y^2, are shown where they are fewer than a tenth of the paths."
# Numbers below are printed with a power of 10.
SMALL = 1e-3
# The reference of a row.
REFERENCE = "ref"


@click.command(epilog=codes_in_words(WORDS), short_help="Run the experiments of papers again.")
@click.argument("name", required=False)
@click.option("--list", "as_list", is_flag=True, help="List the experiments; run nothing.")
@once("--paths", type=int, help="Number of paths of each mean.  [default: the experiment's]")
@click.option("--all", "every", is_flag=True, help="Run the rows that cost most, too.")
@plugins
@seed
@once("--out", type=click.Path(path_type=Path), help=f"Folder for {CSV} and {JSON}.  [default: {FOLDER}/NAME]")
@jobs
@progress_bar
@click.pass_context
def reproduce(context: click.Context, /, **options: Any) -> ExitCode:
    """Run the experiment NAME of a paper again, and set its numbers beside the printed and the exact ones.

    Tells where the print agrees with what is found here, and where with the exact value: up to half a unit of the
    last printed digit and four standard errors. A row that disagrees is a result and no failure.
    """
    # Tables need pandas, which takes longer to load than all other commands need in all.
    from ...lab.experiments import ExperimentRun, experiment_plan  # noqa: PLC0415
    from ...report.files import require_writable  # noqa: PLC0415

    registry, name = loaded(options["plugins"]), options["name"]
    if options["as_list"]:
        return _listed(registry, output(unbroken=True))
    if name is None:
        raise UsageError("reproduce expects the name of an experiment; --list shows all")
    if name not in registry.experiments:
        reason = str(unknown("experiment", name, registry.experiments))
        raise UsageError(f"{reason}{'' if reason.endswith('?') else ';'} --list shows all")
    plan = experiment_plan(registry, name, paths=options["paths"], seed=options["seed"], every=options["every"])
    folder = options["out"] or FOLDER / name
    require_writable(folder)
    run = ExperimentRun(plan)
    code = _carried_out(run, options["jobs"] or available_cores(), registry, options["progress"])
    return _finished(run, registry, tuple(context.obj), folder, code)


def _listed(registry: Registry, console: Console) -> ExitCode:
    shown = empty_table("experiment", "paths", "what it shows", "source")
    for name, entry in registry.experiments.items():
        experiment = entry.experiment
        shown.add_row(name, str(experiment.paths), *map(Text, map(visible, (experiment.title, experiment.source))))
    console.print(shown)
    return ExitCode.OK


def _carried_out(run: "ExperimentRun", jobs: int, registry: Registry, kind: str) -> ExitCode:
    jobs = min(jobs, run.total)
    try:
        with executor_for(jobs, registry.files) as executor, progress(kind, run.total) as show:
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
    from ...lab.experiments import in_words, lines, orders, table  # noqa: PLC0415
    from ...report.files import write_json, write_table  # noqa: PLC0415
    from ...report.provenance import made_with  # noqa: PLC0415

    found, plan = lines(run), run.plan
    fitted = orders(found)
    write_table(table(found), folder / CSV)
    about = {"experiment": plan.experiment.name, "source": plan.experiment.source, "paths": plan.paths}
    about |= {"orders": [each.record() for each in fitted]} if fitted else {}
    write_json({**made_with(registry, plan.seed, arguments), **about}, folder / JSON)
    console = output(unbroken=True)
    console.print(_table(found, f"{plan.experiment.source}: {plan.experiment.title}"))
    console.print()
    words = (*_explained(found), *map(_order, fitted), *_growths(found), *plan.experiment.notes, *in_words(found))
    for text in (*words, f"{CSV} and {JSON} are in {folder}"):
        console.print(Text(visible(text)), soft_wrap=True)
    if code is ExitCode.OK and any(line.sample.error for line in found):
        code = ExitCode.NOT_MEASURED
    style = "green" if code is ExitCode.OK else "red"
    console.print(f"exit code {code.value}: {WORDS[code]}", style=style, soft_wrap=True)
    return code


def _table(found: "list[Line]", title: str) -> Table:
    cells = [_words(line) for line in found]
    # A column is left out that has nothing to say in any row.
    kept = [any(column) for column in zip(*cells, strict=True)]
    shown = empty_table(*compress(HEADINGS, kept))
    shown.title, shown.title_justify = Text(visible(title)), "left"
    for words in cells:
        shown.add_row(*(Text(visible(text)) for text in compress(words, kept)))
    return shown


def _words(line: "Line") -> tuple[str, ...]:
    row, sample = line.row, line.sample
    return (
        row.problem,
        row.scheme,
        f"{line.h:.4g}",
        "" if row.at is None else f"{line.time:.4g}",
        f"({row.observable} - {REFERENCE})^2" if row.reference else row.observable,
        row.printed.digits if row.printed else "",
        with_error(sample.value, sample.std_error),
        f"{sample.effective:.1f}" if _few_effective(line) else "",
        _exactly(line.scheme_mean.value),
        _compared(line.sampling_error, line.ours_and_scheme),
        _exactly(line.exact.value),
        with_error(line.error, sample.std_error),
        _compared(line.print_to_ours, line.print_and_ours),
        _compared(line.print_to_exact, line.print_and_exact),
    )


def _few_effective(line: "Line") -> bool:
    return line.sample.effective < FEW * line.sample.paths


def _explained(found: "list[Line]") -> Iterator[str]:
    yield BRACKETS
    if any(map(_few_effective, found)):
        yield EFFECTIVE
    for reference, problem in dict.fromkeys((line.row.reference, line.row.problem) for line in found):
        if reference:
            yield (
                f"{REFERENCE}: {reference.scheme} with {reference.steps} steps to the final time, "
                f"on the same Brownian paths of {problem}"
            )


def _growths(found: "list[Line]") -> Iterator[str]:
    for line in {(line.row.problem, line.row.scheme, line.h): line for line in found}.values():
        factor, rate = line.scheme_mean.growth
        if isfinite(factor):
            where = f"{line.row.scheme} on {line.row.problem}, h = {line.h:.4g}"
            equation = f", those of the equation as e^({rate:.4f} t)" if isfinite(rate) else ""
            yield f"{where}: second moments change by the factor {factor:.6f} a step{equation}"


def _order(order: "Order") -> str:
    error = f"root mean square of {order.observable} - {REFERENCE}"
    value = with_error(*order.estimate)
    return f"{order.scheme} on {order.problem}: order {value} of the {error}, from {order.step_sizes} step sizes"


def _exactly(value: float) -> str:
    return f"{value:.10g}" if isfinite(value) else ""


def with_error(value: float, std_error: float) -> str:
    """Return a number up to the second digit of its standard error, 2.0062(12); empty if there is none."""
    if not isfinite(value):
        return ""
    if not 0.0 < std_error < 1.0:
        return f"{value:.4g}" + (f" +- {std_error:.2g}" if std_error else "")
    # Small numbers in the notation of their last digit, 3.34(35)e-07.
    size = max(abs(value), std_error)
    exponent = floor(log10(size)) if size < SMALL else 0
    digits = 1 - floor(log10(std_error)) + exponent
    power = f"e{exponent:+03d}" if exponent else ""
    return f"{value * 10.0**-exponent:.{digits}f}({std_error * 10.0 ** (digits - exponent):.0f}){power}"


def _compared(difference: float, word: str) -> str:
    return f"{difference:+.1e} {word}" if word else ""
