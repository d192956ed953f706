"""``calibrate``: calibrate intervals and tests over many seeds."""

import shlex
import time
from pathlib import Path
from typing import Any

import click
from rich.table import Table
from rich.text import Text

from sdaeverify import Settings
from sdaeverify.commands import (
    ExitCode,
    TablePage,
    codes_in_words,
    conclude,
    describe_making,
    empty_table,
    load_and_warn,
    options,
    output,
    print_texts,
    require_writable,
    run_on_workers,
    visible,
    write_table,
    write_tables,
    write_text,
)
from sdaeverify.studying import Registry

from ..calibration.calibration_plan import Calibration, CalibrationPlan, calibration_plan
from ..calibration.rate_tables import Section, markdown, rate_table, sections, summary
from ..calibration.rates import offending

FOLDER = Path("reports", "calibration")
CSV, MARKDOWN = "calibration.csv", "calibration.md"
REPETITIONS = 1000
CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.PLUGIN, ExitCode.INTERRUPTED)


@click.command(epilog=codes_in_words(*CODES), short_help="Count the errors of intervals and tests over many seeds.")
@options.once(
    "--repetitions",
    type=int,
    default=REPETITIONS,
    help="Number of samples of 400 paths; more of smaller, fewer of larger samples.",
)
@click.option(
    "--only", multiple=True, metavar="PATTERN", help="Only studies or cells whose names contain this. Repeatable."
)
@options.seed
@options.once("--out", type=options.PLACE, default=FOLDER, help=f"Folder for {CSV} and {MARKDOWN}.")
@options.jobs
@options.progress_of_cells
@options.plugins
def calibrate(**asked: Any) -> ExitCode:
    """Count how often intervals contain the truth and tests decide wrongly, on cells of known order.

    Writes a table of all rates with their binomial intervals. Succeeds if each agrees with its prescribed range.
    """
    begun = time.monotonic()
    registry = load_and_warn(asked["plugins"], lab=True)
    plan = calibration_plan(registry, asked["seed"], asked["repetitions"], asked["only"])
    require_writable(asked["out"])
    calibration = Calibration(plan)
    code = run_on_workers(calibration, asked["jobs"], registry, asked["progress"])
    if code is not ExitCode.OK:
        return code
    _save(calibration, registry, asked["out"], _command(asked, plan))
    console = output(unbroken=True)
    for section in sections(calibration.rates):
        console.print(_table(section))
        console.print()
    written = f"{CSV}, {MARKDOWN} and report.html are in {asked['out']}"
    print_texts(console, (*summary(calibration.rates), written))
    code = ExitCode.REFUTED if offending(calibration.rates) else ExitCode.OK
    return conclude(code, time.monotonic() - begun)


def _save(calibration: Calibration, registry: Registry, folder: Path, command: str) -> None:
    table = rate_table(calibration.rates, calibration.plan)
    write_table(table, folder / CSV)
    write_tables(folder, f"Calibration: {len(table)} rates", [TablePage.of("Calibration", table)])
    made = describe_making(registry, calibration.plan.seed, ())
    write_text(markdown(calibration.rates, calibration.plan, command, made), folder / MARKDOWN)


def _command(asked: dict[str, Any], plan: CalibrationPlan) -> str:
    """Return the command that reproduces the table; the number of worker processes does not affect it."""
    words = ["python", "-m", "sdaeverify", "calibrate"]
    words += ["--repetitions", str(plan.repetitions)] if plan.repetitions != REPETITIONS else []
    words += ["--seed", str(plan.seed)] if plan.seed != Settings().seed else []
    for name, values in (("--only", asked["only"]), ("--plugin", asked["plugins"])):
        words += [word for value in values for word in (name, value)]
    return shlex.join([*words, "--out", str(asked["out"])] if asked["out"] != FOLDER else words)


def _table(section: Section) -> Table:
    table = empty_table()
    table.title, table.title_justify = Text(section.study), "left"
    for heading in section.headings:
        table.add_column(Text(heading))
    for row in section.rows:
        table.add_row(*(Text(visible(text)) for text in row))
    return table
