"""``sealed``: whether solvers that draw their own random numbers have the law that they claim."""

import json
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Any

import click
from rich.table import Table
from rich.text import Text

from sdaeverify import UsageError
from sdaeverify.commands import (
    ExitCode,
    code_of_verdicts,
    codes_in_words,
    conclude,
    empty_table,
    load_and_warn,
    options,
    output,
    print_texts,
    run_on_workers,
    visible,
)
from sdaeverify.measuring import Verdict
from sdaeverify.studying import select_problems

from .run import PROBLEMS, Row, SealedRun, cells, select_solvers
from .sample import Budget

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.NOTHING, ExitCode.PLUGIN)
STYLES = {Verdict.VERIFIED: "green", Verdict.REFUTED: "bold red", Verdict.INCONCLUSIVE: "yellow"}
SILENT = {Verdict.VERIFIED}


@click.command(epilog=codes_in_words(*CODES), short_help="Judge solvers that draw their own random numbers.")
@click.argument("solvers", metavar="[SOLVER]...", nargs=-1)
@click.option(
    "-p", "--problems", multiple=True, metavar="PATTERN", help=f"Problems.  [default: {', '.join(PROBLEMS)}]"
)
@options.once("--paths", type=int, default=Budget().paths, help="Most paths at each step size.")
@options.once("--looks", type=int, default=Budget().looks, help="How often at most a claim is judged.")
@options.once(
    "--steps", metavar="LIST", help="Steps to the horizon, such as 4,8,16.  [default: those of each solver]"
)
@options.seed
@options.jobs
@options.progress_of_cells
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each row.")
@options.plugins
def sealed(**asked: Any) -> ExitCode:
    """Run solvers that draw their own random numbers, and judge the law of what they return.

    SOLVER is a name, with parameters or as a glob; all but planted ones and those of other libraries if left out. A
    claim about `weak` is of the errors of observables at the horizon, one about `invariant` of those of stationary
    means: an order in h, or `unbiased` within a bound. Each step size has runs and seeds of its own.
    """
    begun, registry = time.monotonic(), load_and_warn(asked["plugins"], lab=True)
    budget = Budget(asked["paths"], asked["looks"], _numbers(asked["steps"]), asked["seed"])
    solvers = select_solvers(registry, asked["solvers"])
    pairs, why = cells(solvers, select_problems(registry, asked["problems"] or PROBLEMS), budget)
    run = SealedRun(pairs, budget)
    if (ended := run_on_workers(run, asked["jobs"], registry, asked["progress"])) is not ExitCode.OK:
        return ended
    found = run.rows
    code = code_of_verdicts(row.finding.verdict for row in found)
    if asked["as_json"]:
        click.echo(json.dumps([*_records(found)], indent=2))
        return code
    console = output(unbroken=True)
    console.print(_table(found))
    print_texts(console, (*_reasons(found), *([""] if why else []), *why, "", _counts(found)))
    return conclude(code, time.monotonic() - begun)


def _numbers(text: str | None) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(",")) if text is not None else ()
    except ValueError:
        raise UsageError(
            f"--steps expects whole numbers separated by commas, such as 4,8,16, got {text!r:.200}"
        ) from None


def _table(found: Sequence[Row]) -> Table:
    table = empty_table("solver", "problem", "about", "claim", "found", "verdict")
    before: tuple[str, str] = ("", "")
    for row in found:
        pair = (row.cell.solver.label, row.cell.label)
        shown = ("", "") if pair == before else pair
        verdict = row.finding.verdict
        texts = (*shown, _about(row), str(row.finding.claim or ""), _estimate(row))
        table.add_row(*(Text(visible(text)) for text in texts), Text(verdict.value, style=STYLES.get(verdict, "")))
        before = pair
    return table


def _about(row: Row) -> str:
    return f"{row.measure} of {row.finding.quantity}" if row.finding.quantity else row.measure


def _estimate(row: Row) -> str:
    low, high = row.finding.low, row.finding.high
    return f"{low:.3g} to {high:.3g}" if isfinite(low) and isfinite(high) else ""


def _reasons(found: Sequence[Row]) -> Iterator[str]:
    for row in found:
        if row.finding.verdict not in SILENT:
            verdict = row.finding.verdict.value
            yield f"{row.cell.solver.label} on {row.cell.label}, {_about(row)}: {verdict}: {row.finding.reason}"


def _counts(found: Sequence[Row]) -> str:
    counts = Counter(row.finding.verdict.value for row in found)
    return ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())) or "no solver and problem fit"


def _records(found: Sequence[Row]) -> Iterator[Mapping[str, object]]:
    for row in found:
        one = row.finding
        yield {
            "solver": row.cell.solver.label,
            "problem": row.cell.label,
            "measure": row.measure,
            "quantity": one.quantity,
            "claim": str(one.claim) if one.claim else None,
            "verdict": one.verdict.value,
            "reason": str(one.reason),
            **{name: _number(getattr(one, name)) for name in ("estimate", "low", "high", "resolution")},
        }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
