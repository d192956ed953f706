"""``demo``: a first report, in seconds."""

from pathlib import Path
from typing import Any

import click

from ...api import plan_of
from ...contracts.settings import Settings
from ...registry.load import Registry
from ...report.files import require_writable
from ...report.plain import visible
from ...report.sentences import counts_of, overview, wrap_styled
from ...report.verdict_row import VerdictRow
from ...workers.limits import read_limits
from ..console import output, output_to_stderr, print_texts
from ..exit_codes import ExitCode
from ..loading import load_and_warn
from ..options import PLACE, once
from ..running import Run, advance, workers

FOLDER = Path("reports", "demo")
# Shipped schemes: one of order 1/2, one of order 1, and one for mechanics with a constraint.
SCHEMES, PROBLEMS, MEASURES = "euler-maruyama,milstein,half-explicit-euler", "gbm,pendulum", "strong"
SETTINGS = Settings(paths=1024, levels=5)


@click.command(short_help="Run three schemes on two problems, in seconds.")
@once("--out", type=PLACE, default=FOLDER, help="Folder of the report.")
@click.pass_context
def demo(context: click.Context, /, out: Path) -> ExitCode:
    """Test the claimed strong orders of three schemes on two problems.

    Takes a few seconds, and prints the path of an HTML page at the end.
    """
    require_writable(out)
    registry = load_and_warn(())
    with workers(*read_limits(0.0, "0", 1), registry) as crew:
        run = _run(registry, tuple(context.obj), out)
        result = advance(run, crew, "none")
        run.write_page()
    _show(result.rows.verdicts, out)
    return ExitCode.OK


def _run(registry: Registry, words: tuple[str, ...], out: Path) -> Any:
    with output_to_stderr():
        todo = plan_of(registry, SCHEMES, PROBLEMS, MEASURES)
    return Run(todo, SETTINGS, registry, words, out)


def _show(rows: list[VerdictRow], out: Path) -> None:
    console = output()
    console.print(*overview((row for row in rows if "@" not in row.quantity), plain=console.options.ascii_only), "")
    told = [
        counts_of(rows, ()),
        f"The page with the pictures is {out / 'report.html'}: open it in a browser.",
        f"Next: sdaeverify show {out} milstein gbm",
        "      sdaeverify matrix -p gbm",
    ]
    print_texts(console, [line for text in told for line in wrap_styled(visible(text), console.width)])
