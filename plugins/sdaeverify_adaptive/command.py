"""``adaptive``: test the claims of adaptive solvers about their tolerance."""

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
from sdaeverify_solvers import print_rows, records, select_solvers

from .examination import AdaptiveWork
from .run import HOOK, KIND, PROBLEMS, AdaptiveRun, cells, work_of
from .sample import Budget

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.NOTHING, ExitCode.PLUGIN)

SILENT = {Verdict.VERIFIED, Verdict.NOT_APPLICABLE}


@click.command(epilog=codes_in_words(*CODES), short_help="Test the claims of adaptive solvers.")
@click.argument("solvers", metavar="[SOLVER]...", nargs=-1)
@click.option(
    "-p", "--problems", multiple=True, metavar="PATTERN", help=f"Problems.  [default: {', '.join(PROBLEMS)}]"
)
@options.once("--paths", type=int, default=Budget().paths, help="Number of paths.")
@options.once(
    "--tolerances", metavar="LIST", help="Tolerances, such as 1e-2,1e-3,1e-4.  [default: those of each solver]"
)
@options.seed
@options.jobs
@options.progress_of_cells
@options.run_folder
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each row.")
@options.plugins
def adaptive(**asked: Any) -> ExitCode:
    """Solve problems at several tolerances on one Brownian path, and judge the claims of adaptive solvers.

    SOLVER is a name, with parameters or as a glob; by default all except planted ones. A claim about `tolerance` is
    the rate of the error in the tolerance, one about `tolerance-steps` the order in the mean number of steps, and one
    about `tolerance-law` the bias of observables.
    """
    begun, registry = time.monotonic(), load_and_warn(asked["plugins"], lab=True)
    budget = Budget(asked["paths"], _numbers(asked["tolerances"]), asked["seed"])
    solvers = select_solvers(registry, HOOK, KIND, asked["solvers"])
    pairs, why = cells(solvers, select_problems(registry, asked["problems"] or PROBLEMS))
    run = AdaptiveRun(pairs, budget)
    if asked["out"] is not None:
        require_run_folder(asked["out"])
    if (ended := run_on_workers(run, asked["jobs"], registry, asked["progress"])) is not ExitCode.OK:
        return ended
    found, kept = run.rows, list[str]()
    if asked["out"] is not None:
        settings = replace(Settings(), paths=budget.paths, seed=budget.seed)
        kept = [save_results(asked["out"], AdaptiveWork(run, tuple(why)), registry, settings)]
    code = code_of_verdicts(row.finding.verdict for row in found)
    if asked["as_json"]:
        work = {id(cell): work_of(each) for cell, each in run.known}
        told = ({**record, **work[id(row.cell)]} for row, record in zip(found, records(found), strict=True))
        click.echo(json.dumps([*told], indent=2))
        return code
    print_rows(found, why, SILENT)
    print_texts(output(), kept)
    return conclude(code, time.monotonic() - begun)


def _numbers(text: str | None) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(",")) if text is not None else ()
    except ValueError:
        raise UsageError(
            f"--tolerances expects numbers separated by commas, such as 1e-2,1e-3,1e-4, got {text!r:.200}"
        ) from None
