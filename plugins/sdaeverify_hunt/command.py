"""``hunt``: search random examples for one that breaks a claim."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from sdaeverify import Settings, UsageError
from sdaeverify.commands import (
    ExitCode,
    codes_in_words,
    complain,
    options,
    output,
    output_to_stderr,
    print_texts,
    require_run_folder,
    require_writable,
    save_results,
)
from sdaeverify.studying import load_registry, select_measures, select_schemes

from .hunting import hunt as hunt_schemes
from .kept import hunt_work
from .options import SHRINKING
from .report import HuntReport

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOTHING, ExitCode.PLUGIN, ExitCode.INTERRUPTED)
# Database of hypothesis, in the folder of the counterexample.
DATABASE = ".sdaeverify-hunt"


@click.command(epilog=codes_in_words(*CODES), short_help="Search for problems on which claims fail.")
@click.argument("schemes", metavar="SCHEME...", nargs=-1, required=True)
@click.option("-m", "--measure", "measures", multiple=True, help="Measure of the claims to test.  [default: all]")
@click.option(
    "--when", multiple=True, metavar="TRAITS", help="Traits that all examples must have, separated by commas."
)
@click.option("--form", "forms", multiple=True, help="Form of the examples.  [default: those of the scheme]")
@options.once("--examples", type=int, help="Examples drawn for each scheme, measure and form.  [default: 200]")
@options.once("--minutes", type=float, help="Total time of the search, instead of a number of examples.")
@options.once(
    "--shrinking",
    type=float,
    default=SHRINKING,
    help="Additional seconds to shrink and confirm a counterexample.",
)
@options.once(
    "--out",
    type=options.PLACE,
    metavar="FILE.py|DIR",
    help="Write a counterexample as a plugin file, and a test next to it; save the results in DIR as a run, too.",
)
@options.seed
@options.jobs
@options.progress_of_cells
@options.plugins
def hunt(**asked: Any) -> ExitCode:
    """Draw problems at random until a claim of SCHEME fails, and shrink the counterexample.

    A counterexample is confirmed by a separate run before it counts. At the end the tried examples are listed. The
    result does not depend on the number of jobs unless a time limit ends the search. An interrupted hunt with --out
    continues when it is run again.
    """
    out, folder = _places(asked.pop("out"))
    schemes, quiet = asked.pop("schemes"), asked.pop("progress") == "none"
    when = [each.strip() for text in asked.pop("when") for each in text.split(",") if each.strip()]
    database = None if out is None else out.parent / DATABASE
    tell = str if quiet else lambda line: complain("", line)
    with output_to_stderr():
        report = hunt_schemes(schemes, when=when, database=database, tell=tell, **asked)
        files = () if out is None else report.write(out)
        kept = [] if folder is None else [_keep(folder, report, schemes, {**asked, "when": when})]
    print_texts(output(), [*report.sentences(), *(f"written: {file}" for file in files), *kept])
    if not report.looked_at:
        return ExitCode.NOTHING
    return ExitCode.REFUTED if report.found else ExitCode.OK


def _places(out: Path | None) -> tuple[Path | None, Path | None]:
    """Return the file of a counterexample, and the folder of a run if ``--out`` names a folder.

    Raises
    ------
    UsageError
        If it is the name of another kind of file, or cannot be written to.
    """
    if out is None:
        return None, None
    if out.suffix == ".py":
        require_writable(out.parent, "--out")
        return out, None
    if out.suffix and not out.is_dir():
        raise UsageError(f"--out expects a file that ends in .py or a folder, got {str(out)!r:.200}")
    require_run_folder(out)
    return out / "counterexample.py", out


def _keep(folder: Path, report: HuntReport, schemes: Sequence[str], asked: Mapping[str, Any]) -> str:
    """Save the results as a run, and return the line that says so."""
    registry = load_registry(asked["plugins"])
    measures = {measure.name: measure for measure in select_measures(registry)}
    given = {"--examples": asked["examples"], "--minutes": asked["minutes"], "--when": ",".join(asked["when"])}
    words = ["--seed", str(asked["seed"])]
    words += [word for name, value in given.items() if value for word in (name, str(value))]
    words += [word for form in asked["forms"] for word in ("--form", form)]
    work = hunt_work(report, select_schemes(registry, schemes), measures, words)
    return save_results(folder, work, registry, Settings(seed=asked["seed"]))
