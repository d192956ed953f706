"""``sealed``: whether solvers that draw their own random numbers have the law that they claim."""

import json
import time
from dataclasses import replace
from typing import Any

import click

from sdaeverify import Settings, UsageError
from sdaeverify.commands import (
    ExitCode,
    code_of_verdicts,
    codes_in_words,
    conclude,
    load_and_warn,
    options,
    output,
    print_texts,
    require_run_folder,
    run_on_workers,
    save_results,
)
from sdaeverify.measuring import Verdict
from sdaeverify.studying import select_problems
from sdaeverify_solvers import print_rows, records

from .examination import SealedWork
from .run import PROBLEMS, SealedRun, cells, select_solvers
from .sample import Budget

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.NOTHING, ExitCode.PLUGIN)
SILENT = {Verdict.VERIFIED}


@click.command(epilog=codes_in_words(*CODES), short_help="Judge solvers that draw their own random numbers.")
@click.argument("solvers", metavar="[SOLVER]...", nargs=-1)
@click.option(
    "-p", "--problems", multiple=True, metavar="PATTERN", help=f"Problems.  [default: {', '.join(PROBLEMS)}]"
)
@options.once("--paths", type=int, default=Budget().paths, help="Largest number of paths at each step size.")
@options.once("--looks", type=int, default=Budget().looks, help="Largest number of times that a claim is judged.")
@options.once(
    "--steps", metavar="LIST", help="Steps to the horizon, such as 4,8,16.  [default: those of each solver]"
)
@options.seed
@options.jobs
@options.progress_of_cells
@options.run_folder
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each row.")
@options.plugins
def sealed(**asked: Any) -> ExitCode:
    """Run solvers that draw their own random numbers, and judge the law of their results.

    SOLVER is a name, with parameters or as a glob; by default all except planted ones and those of other libraries. A
    claim about `weak` concerns errors of observables at the final time, one about `invariant` errors of stationary
    means: an order in h, or `unbiased` within a bound. Each step size has separate runs and seeds.
    """
    begun, registry = time.monotonic(), load_and_warn(asked["plugins"], lab=True)
    budget = Budget(asked["paths"], asked["looks"], _numbers(asked["steps"]), asked["seed"])
    solvers = select_solvers(registry, asked["solvers"])
    pairs, why = cells(solvers, select_problems(registry, asked["problems"] or PROBLEMS), budget)
    run = SealedRun(pairs, budget)
    if asked["out"] is not None:
        require_run_folder(asked["out"])
    if (ended := run_on_workers(run, asked["jobs"], registry, asked["progress"])) is not ExitCode.OK:
        return ended
    found, kept = run.rows, list[str]()
    if asked["out"] is not None:
        settings = replace(Settings(), paths=budget.paths, seed=budget.seed)
        kept = [save_results(asked["out"], SealedWork(run, tuple(why)), registry, settings)]
    code = code_of_verdicts(row.finding.verdict for row in found)
    if asked["as_json"]:
        click.echo(json.dumps([*records(found)], indent=2))
        return code
    print_rows(found, why, SILENT)
    print_texts(output(), kept)
    return conclude(code, time.monotonic() - begun)


def _numbers(text: str | None) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(",")) if text is not None else ()
    except ValueError:
        raise UsageError(
            f"--steps expects whole numbers separated by commas, such as 4,8,16, got {text!r:.200}"
        ) from None
