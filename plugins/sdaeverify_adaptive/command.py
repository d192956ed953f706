"""``adaptive``: whether solvers that choose their steps keep what their tolerance promises."""

import json
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from math import isfinite
from typing import Any

import click
from rich.table import Table
from rich.text import Text

from sdaeverify import UsageError
from sdaeverify.commands import (
    ExitCode,
    codes_in_words,
    conclude,
    empty_table,
    load_and_warn,
    options,
    output,
    print_texts,
    visible,
)
from sdaeverify.measuring import Verdict
from sdaeverify.studying import UNMEASURED, Registry, one_thread, parse_label, select_problems, unknown

from .contract import Adaptive
from .run import Measured, Row, cells, measured, rows
from .sample import Budget

HOOK = "sdaeverify_adaptive"
PLANTED = "planted-"
# Ito's sense, additive noise, an area, and an equation without reflection symmetry.
PROBLEMS = ("gbm[a=0.1,b=0.8]", "ou", "heisenberg", "shear")
WORDS = {
    ExitCode.OK: "no claim is refuted, and no check fails",
    ExitCode.REFUTED: "a claim is refuted, or a check fails",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.NOT_MEASURED: "something could not be measured",
    ExitCode.NOTHING: "nothing was there to be measured",
    ExitCode.PLUGIN: "a requested plugin failed to load",
}
STYLES = {Verdict.VERIFIED: "green", Verdict.REFUTED: "bold red", Verdict.INCONCLUSIVE: "yellow"}


@click.command(epilog=codes_in_words(WORDS), short_help="Judge solvers that choose their steps.")
@click.argument("solvers", metavar="[SOLVER]...", nargs=-1)
@click.option(
    "-p", "--problems", multiple=True, metavar="PATTERN", help=f"Problems.  [default: {', '.join(PROBLEMS)}]"
)
@options.once("--paths", type=int, default=Budget().paths, help="Number of paths.")
@options.once("--tolerances", metavar="LIST", help="Such as 1e-2,1e-3,1e-4.  [default: those of each solver]")
@options.seed
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each row.")
@options.plugins
def adaptive(**asked: Any) -> ExitCode:
    """Solve problems at several tolerances on one Brownian path, and judge what adaptive solvers claim.

    SOLVER is a name, with parameters or as a glob; all but planted ones if left out. A claim about `tolerance` is of
    the rate of the error in the tolerance, one about `tolerance-steps` of the order in the mean number of steps, one
    about `tolerance-law` of the bias of observables.
    """
    begun, registry = time.monotonic(), load_and_warn(asked["plugins"], lab=True)
    budget = Budget(asked["paths"], _numbers(asked["tolerances"]), asked["seed"])
    pairs, why = cells(_solvers(registry, asked["solvers"]), select_problems(registry, asked["problems"] or PROBLEMS))
    with one_thread():
        done = [measured(cell, budget) for cell in pairs]
    found = rows(done)
    code = _code(found)
    if asked["as_json"]:
        click.echo(json.dumps([*_records(found, done)], indent=2))
        return code
    console = output(unbroken=True)
    console.print(_table(found))
    print_texts(console, (*_reasons(found), *([""] if why else []), *why, "", _counts(found)))
    return conclude(code, WORDS, time.monotonic() - begun)


def _numbers(text: str | None) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(",")) if text is not None else ()
    except ValueError:
        raise UsageError(
            f"--tolerances expects numbers separated by commas, such as 1e-2,1e-3,1e-4, got {text!r:.200}"
        ) from None


def _solvers(registry: Registry, patterns: Sequence[str]) -> list[Adaptive]:
    entries, found = registry.entries.get(HOOK, {}), dict[str, Adaptive]()
    if not patterns:
        return [entry.thing for name, entry in entries.items() if not name.startswith(PLANTED)]
    for pattern in patterns:
        name, texts = parse_label(pattern)
        names = [known for known in entries if fnmatchcase(known, pattern)] or [name]
        if names == [name] and name not in entries:
            raise UsageError(f"{unknown('adaptive solver', name, entries)} (known: {', '.join(entries)})")
        made = (entries[each].make(texts) if texts else entries[each].thing for each in names)
        found |= {solver.label: solver for solver in made}
    return list(found.values())


def _code(found: Sequence[Row]) -> ExitCode:
    verdicts = {row.finding.verdict for row in found}
    if Verdict.REFUTED in verdicts:
        return ExitCode.REFUTED
    if verdicts & UNMEASURED:
        return ExitCode.NOT_MEASURED
    return ExitCode.OK if found else ExitCode.NOTHING


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


def _records(found: Sequence[Row], done: Sequence[Measured]) -> Iterator[Mapping[str, object]]:
    work = [(each.cell, [*_work(each)]) for each in done]
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
            "work": next(took for cell, took in work if cell is row.cell),
        }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def _work(each: Measured) -> Iterator[Mapping[str, float]]:
    """Yield what each tolerance took and came to."""
    if each.sample is None:
        return
    runs, budget = each.sample.runs, each.sample.budget
    rms = (each.sample.errors**2).sum(axis=1).mean(axis=-1) ** 0.5
    for k, tolerance in enumerate(budget.tolerances):
        counted = {name: float(getattr(runs, name)[k].mean()) for name in ("steps", "rejected", "evaluations")}
        yield {"tolerance": tolerance, "rms": float(rms[k]), **counted}
