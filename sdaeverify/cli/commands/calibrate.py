"""``calibrate``: whether intervals and tests keep what they promise, over many seeds."""

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.table import Table
from rich.text import Text

from ...contracts.settings import Settings
from ...report.plain import empty_table, visible
from ..console import PROGRAM, conclude, output, print_texts
from ..exit_codes import ExitCode
from ..loading import load_quietly
from ..on_workers import run_on_workers
from ..options import PLACE, jobs, once, plugins, progress_bar, seed

if TYPE_CHECKING:
    from ...lab.calibration.calibration_plan import Calibration, CalibrationPlan
    from ...lab.calibration.rate_tables import Section

FOLDER = Path("reports", "calibration")
CSV, MARKDOWN = "calibration.csv", "calibration.md"
REPETITIONS = 1000
WORDS = {
    ExitCode.OK: "every rate agrees with what is promised",
    ExitCode.REFUTED: "a rate disagrees with what is promised",
}


@click.command(short_help="Try out intervals and tests over many seeds.")
@once(
    "--repetitions", type=int, default=REPETITIONS, help="Samples of 400 paths; more smaller and fewer larger ones."
)
@click.option(
    "--only", multiple=True, metavar="PATTERN", help="Studies or cells in whose names this is found. Repeatable."
)
@seed
@once("--out", type=PLACE, default=FOLDER, help=f"Folder for {CSV} and {MARKDOWN}.")
@jobs
@progress_bar
@plugins
def calibrate(**options: Any) -> ExitCode:
    """Count how often intervals contain the truth and tests decide wrongly, on cells of known order.

    Writes a table of all rates with their binomial intervals. Succeeds if each agrees with what is promised for it.
    """
    # Tables need pandas, which takes longer to load than all other commands need in all.
    from ...lab.calibration.calibration_plan import Calibration, calibration_plan  # noqa: PLC0415
    from ...lab.calibration.rate_tables import sections, summary  # noqa: PLC0415
    from ...lab.calibration.rates import offending  # noqa: PLC0415
    from ...report.files import require_writable  # noqa: PLC0415

    begun = time.monotonic()
    registry = load_quietly(options["plugins"], lab=True)
    plan = calibration_plan(registry, options["seed"], options["repetitions"], options["only"])
    require_writable(options["out"])
    calibration = Calibration(plan)
    code = run_on_workers(calibration, options["jobs"], registry, options["progress"])
    if code is not ExitCode.OK:
        return code
    _save(calibration, options["out"], _command(options, plan))
    console = output(unbroken=True)
    for section in sections(calibration.rates):
        console.print(_table(section))
        console.print()
    written = f"{CSV}, {MARKDOWN} and report.html are in {options['out']}"
    print_texts(console, (*summary(calibration.rates), written))
    code = ExitCode.REFUTED if offending(calibration.rates) else ExitCode.OK
    return conclude(code, WORDS, time.monotonic() - begun)


def _save(calibration: "Calibration", folder: Path, command: str) -> None:
    from ...lab.calibration.rate_tables import markdown, rate_table  # noqa: PLC0415
    from ...report.files import write_table, write_text  # noqa: PLC0415
    from ...report.html import PAGE, write_tables  # noqa: PLC0415
    from ...report.html.verifier import coverage, read_csv  # noqa: PLC0415

    table = rate_table(calibration.rates, calibration.plan)
    write_table(table, folder / CSV)
    sentence = f"Calibration: {len(table)} rates"
    write_tables(folder / PAGE, sentence, (), verifier={"calibration": coverage(read_csv(folder / CSV))})
    write_text(markdown(calibration.rates, calibration.plan, command), folder / MARKDOWN)


def _command(options: dict[str, Any], plan: "CalibrationPlan") -> str:
    """Return the command that makes the same table again; worker processes do not matter for it."""
    words = ["python", "-m", PROGRAM, "calibrate"]
    words += ["--repetitions", str(plan.repetitions)] if plan.repetitions != REPETITIONS else []
    words += ["--seed", str(plan.seed)] if plan.seed != Settings().seed else []
    for name, values in (("--only", options["only"]), ("--plugin", options["plugins"])):
        words += [word for value in values for word in (name, value)]
    return shlex.join([*words, "--out", str(options["out"])] if options["out"] != FOLDER else words)


def _table(section: "Section") -> Table:
    table = empty_table()
    table.title, table.title_justify = Text(section.study), "left"
    for heading in section.headings:
        table.add_column(Text(heading))
    for row in section.rows:
        table.add_row(*(Text(visible(text)) for text in row))
    return table
