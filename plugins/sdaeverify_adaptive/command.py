"""``adaptive``: test the claims of adaptive solvers about their tolerance."""

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

from .run import PROBLEMS, AdaptiveRun, Row, cells, select_solvers, work_of
from .sample import Budget

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.NOTHING, ExitCode.PLUGIN)
STYLES = {Verdict.VERIFIED: "green", Verdict.REFUTED: "bold red", Verdict.INCONCLUSIVE: "yellow"}


@click.command(epilog=codes_in_words(*CODES), short_help="Judge solvers that choose their steps.")
@click.argument("solvers", metavar="[SOLVER]...", nargs=-1)
@click.option(
    "-p", "--problems", multiple=True, metavar="PATTERN", help=f"Problems.  [default: {', '.join(PROBLEMS)}]"
)
@options.once("--paths", type=int, default=Budget().paths, help="Number of paths.")
@options.once("--tolerances", metavar="LIST", help="Such as 1e-2,1e-3,1e-4.  [default: those of each solver]")
@options.seed
@options.jobs
@options.progress_of_cells
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
    solvers = select_solvers(registry, asked["solvers"])
    pairs, why = cells(solvers, select_problems(registry, asked["problems"] or PROBLEMS))
    run = AdaptiveRun(pairs, budget)
    if (ended := run_on_workers(run, asked["jobs"], registry, asked["progress"])) is not ExitCode.OK:
        return ended
    found = run.rows
    code = code_of_verdicts(row.finding.verdict for row in found)
    if asked["as_json"]:
        click.echo(json.dumps([*_records(found, run)], indent=2))
        return code
    console = output(unbroken=True)
    console.print(_table(found))
    print_texts(console, (*_reasons(found), *([""] if why else []), *why, "", _counts(found)))
    return conclude(code, time.monotonic() - begun)


def _numbers(text: str | None) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(",")) if text is not None else ()
    except ValueError:
        raise UsageError(
            f"--tolerances expects numbers separated by commas, such as 1e-2,1e-3,1e-4, got {text!r:.200}"
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
        if row.finding.verdict not in {Verdict.VERIFIED, Verdict.NOT_APPLICABLE}:
            verdict = row.finding.verdict.value
            yield f"{row.cell.solver.label} on {row.cell.label}, {_about(row)}: {verdict}: {row.finding.reason}"


def _counts(found: Sequence[Row]) -> str:
    counts = Counter(row.finding.verdict.value for row in found)
    return ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())) or "no solver and problem fit"


def _records(found: Sequence[Row], run: AdaptiveRun) -> Iterator[Mapping[str, object]]:
    took = {id(cell): work_of(each) for cell, each in zip(run.cells, run.done, strict=True)}
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
            **took[id(row.cell)],
        }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
