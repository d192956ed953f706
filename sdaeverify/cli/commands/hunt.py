"""``hunt``: search random examples for one that breaks a claim."""

from pathlib import Path
from typing import Any

import click

from ...contracts.labels import split_list
from ...errors import UsageError
from ...report.files import require_writable
from ...testing.hunting.hunt import hunt as hunt_schemes
from ...testing.hunting.options import SHRINKING
from ...workers.limits import available_cores
from ..console import complain, output, output_to_stderr, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..options import PLACE, jobs, once, plugins, progress_of_cells, seed

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOTHING, ExitCode.PLUGIN, ExitCode.INTERRUPTED)
# Database of hypothesis, in the folder of the counterexample.
DATABASE = ".sdaeverify-hunt"


@click.command(epilog=codes_in_words(*CODES), short_help="Look for problems on which claims do not hold.")
@click.argument("schemes", metavar="SCHEME...", nargs=-1, required=True)
@click.option("-m", "--measure", "measures", multiple=True, help="Whose claims are attacked.  [default: all]")
@click.option("--when", multiple=True, metavar="TRAITS", help="Traits that each example has, separated by commas.")
@click.option("--form", "forms", multiple=True, help="Form of the examples.  [default: those of the scheme]")
@once("--examples", type=int, help="Examples drawn for each scheme, measure and form.  [default: 200]")
@once("--minutes", type=float, help="Time of the search of all, in place of a number.")
@once(
    "--shrinking",
    type=float,
    default=SHRINKING,
    help="Seconds that what is found is shrunk, and confirmed, on top.",
)
@once("--out", type=PLACE, metavar="FILE.py", help="Write a counterexample as a plugin file, and a test beside it.")
@seed
@jobs
@progress_of_cells
@plugins
def hunt(**options: Any) -> ExitCode:
    """Draw problems at random until a claim of SCHEME fails, and shrink the counterexample.

    A counterexample is confirmed by a separate run before it counts. At the end the tried examples are listed. The
    result does not depend on the number of jobs unless a time limit ends the search. An interrupted hunt with --out
    continues when it is run again.
    """
    out: Path | None = options.pop("out")
    if out is not None and out.suffix != ".py":
        raise UsageError(f"--out expects a file that ends in .py, got {str(out)!r:.200}")
    if out is not None:
        require_writable(out.parent, "--out")
    options["jobs"] = options["jobs"] or available_cores()
    quiet = options.pop("progress") == "none"
    schemes = [each for text in options.pop("schemes") for each in split_list(text)]
    when = [each for text in options.pop("when") for each in split_list(text)]
    database = None if out is None else out.parent / DATABASE
    tell = str if quiet else lambda line: complain("", line)
    with output_to_stderr():
        report = hunt_schemes(schemes, when=when, database=database, tell=tell, **options)
        files = () if out is None else report.write(out)
    print_texts(output(), [*report.sentences(), *(f"written: {file}" for file in files)])
    if not report.looked_at:
        return ExitCode.NOTHING
    return ExitCode.REFUTED if report.found else ExitCode.OK
