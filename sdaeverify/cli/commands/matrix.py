"""``matrix``: cross schemes with problems and judge every claim."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from rich.table import Table
from rich.text import Text

from ...api import plan_of
from ...contracts.settings import Settings, SettingsOptions, read_levels, settings_from
from ...contracts.spelling import counted
from ...errors import UsageError
from ...registry.load import Registry
from ...report.folders import read_verdicts
from ...report.pictures import WORDS
from ...report.plain import text_table
from ...report.sentences import ATTENTION
from ...study import Plan
from ...study.plan import shard
from ..console import complain, output, output_to_stderr, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn
from ..options import (
    PLACE,
    as_json,
    jobs,
    levels_text,
    limits,
    once,
    options_of,
    plugins,
    progress_of_cells,
    quiet,
    seed,
    selection,
)
from ..running import Run, carry_out, workers

DEFAULTS = Settings()
SHARD = re.compile("([0-9]{1,6})/([0-9]{1,6})")
FOLDER = Path("reports", "latest")
COUNT = re.compile("[0-9]{1,9}")


@click.command(epilog=codes_in_words(), short_help="Run schemes on problems and judge every claim.")
@selection
@plugins
@once(
    "--paths",
    type=int,
    default=DEFAULTS.paths,
    help="Largest number of paths. Chains: an eighth, at least 1024.",
)
@once(
    "--levels",
    metavar="LEVELS",
    help=f"Steps as COARSEST..FINEST, doubling; or a number of levels, from {DEFAULTS.coarsest} steps on.  "
    f"[default: {levels_text(DEFAULTS)}]",
)
@once(
    "--first-levels",
    type=int,
    help="Number of levels computed first, enough to guard verdicts from one step.  "
    f"[default: {DEFAULTS.first_levels}; all that --levels gives]",
)
@seed
@once(
    "--confidence",
    type=float,
    default=DEFAULTS.confidence,
    help="Confidence of intervals, and of all verdicts of a run together.",
)
@once(
    "--block", type=int, default=DEFAULTS.block, help="Paths simulated together; part of what determines the noise."
)
@once(
    "--max-looks",
    type=int,
    default=DEFAULTS.max_looks,
    help="Largest number of times that a cell is judged.",
)
@once(
    "--tests-reserved",
    type=int,
    default=DEFAULTS.tests_reserved,
    help="Number of tests that share the error level of early decisions.",
)
@once("--out", type=PLACE, default=FOLDER, help="Folder of the report.")
@jobs
@once(
    "--executor",
    metavar="NAME[:ADDRESS]",
    default="processes",
    help="Executor: processes, serial, dask, dask://HOST:PORT, or one of a plugin.",
)
@once("--shard", metavar="I/N", help="Run the I-th of N parts of all pairs of scheme and problem, for merge.")
@progress_of_cells
@limits
@click.option("--fresh", is_flag=True, help="Compute everything again; ignore evidence in the folder.")
@click.option("-x", "--exitfirst", is_flag=True, help="Stop after the first problem on which a claim is refuted.")
@click.option("--lf", is_flag=True, help="Run only the cells that the last run into the folder did not verify.")
@click.option("--modified", is_flag=True, help="Also find the equations that schemes solve to one order more.")
@as_json
@quiet
@click.option("--no-html", is_flag=True, help="Do not write the page report.html.")
@click.option("--dry-run", is_flag=True, help="List all cells, and why some cannot be run; run and write nothing.")
@click.pass_context
def matrix(context: click.Context, /, **options: Any) -> ExitCode:
    """Cross schemes with problems, measure every cell, judge every claim.

    Without options, all registered entries are run at a small budget.
    """
    settings = _settings(options)
    if options["quiet"] and options["as_json"]:
        raise UsageError("contradictory options: choose one of --quiet and --json")
    registry = load_and_warn(options["plugins"])
    if not registry.plugins:
        return _nothing("no plugin is found; is sdaeverify installed? Run pip install . in its folder")
    with workers(*options_of(options), registry, options["executor"]) as crew:
        problems, measures = options["problems"], options["measures"]
        # Without -s, a program that was named is the only one of interest.
        schemes = options["schemes"] or registry.sourced
        with output_to_stderr():
            # For a dry run, starting workers would take as long as everything else.
            asked = None if options["dry_run"] else crew.executor
            todo = plan_of(registry, schemes, problems, measures, asked)
        if options["lf"]:
            todo = _open_part(todo, options["out"])
        if options["shard"]:
            todo = shard(todo, *_read_shard(options["shard"]))
        if not todo.cells:
            return _nothing(f"all was verified in {options['out']}" if options["lf"] else _describe_missing(registry))
        if options["dry_run"]:
            return _show_plan(todo, settings)
        folder, fresh, modified = (options[name] for name in ("out", "fresh", "modified"))
        run = Run(todo, settings, registry, tuple(context.obj), folder, fresh, modified=modified)
        run.page, run.first_only = not options["no_html"], options["exitfirst"]
        run.as_json, run.quiet = options["as_json"], options["quiet"]
        return carry_out(run, crew, options["progress"])


def _settings(options: dict[str, Any]) -> Settings:
    given = {name: options[name] for name in SettingsOptions.__annotations__ if options.get(name) is not None}
    if COUNT.fullmatch(levels := given.get("levels", "")):
        given["levels"] = int(levels)
    elif levels:
        given["coarsest"], given["levels"] = read_levels("--levels", levels)
    return settings_from(**given)


def _read_shard(text: str) -> tuple[int, int]:
    match = SHARD.fullmatch(text)
    index, count = (int(number) for number in match.groups()) if match else (0, 0)
    if not 1 <= index <= count:
        raise UsageError(f"--shard expects I/N with 1 <= I <= N, such as 3/16, got {text!r}")
    return index, count


def _open_part(plan: Plan, folder: Path) -> Plan:
    """Return the plan restricted to cells of the last run in a folder that need attention.

    Raises
    ------
    UsageError
        If the folder holds no run.
    """
    rows = read_verdicts(folder).verdicts
    left = {(row["scheme"], row["problem"], row["measure"]) for row in rows if row["verdict"] in ATTENTION}
    problems = []
    for made in plan.problems:
        cells = tuple(c for c in made.cells if (c.scheme.label, c.spec.label, c.measure.name) in left)
        if cells:
            problems.append(replace(made, cells=cells))
    return Plan(tuple(problems))


def _describe_missing(registry: Registry) -> str:
    kinds = {"scheme": registry.schemes, "problem": registry.problems, "measure": registry.measures}
    missing = " and no ".join(kind for kind, entries in kinds.items() if not entries)
    return f"no {missing} is registered; sdaeverify list plugins says why"


def _nothing(reason: str) -> ExitCode:
    complain("error", f"nothing to measure: {reason}")
    return ExitCode.NOTHING


def _show_plan(todo: Plan, settings: Settings) -> ExitCode:
    console = output(unbroken=True)
    console.print(_plan_table(todo))
    runnable = sum(cell.verdict is None for cell in todo.cells)
    budget = f"{settings.paths} paths, {levels_text(settings)} steps, seed {settings.seed}"
    print_texts(console, [f"{runnable} of {counted(len(todo.cells), 'cell')} would be run: {budget}"])
    return ExitCode.OK if runnable else ExitCode.NOTHING


def _plan_table(todo: Plan) -> Table:
    """Return a table with a row for each cell: whether it is run, and its view or the reason why not."""
    run = Text("run", style="green")
    rows = (
        (
            Text(WORDS[cell.verdict], style="dim") if cell.verdict else run,
            cell.scheme.label,
            cell.spec.label,
            cell.measure.name,
            cell.reason or cell.view,
        )
        for cell in todo.cells
    )
    return text_table(("", "scheme", "problem", "measure", "view or reason"), rows)
