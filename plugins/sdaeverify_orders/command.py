"""``orders``: order conditions of a scheme for classes of equations."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import isnan
from pathlib import Path
from typing import Any

import click
from rich.table import Table
from rich.text import Text

from sdaeverify import Scheme, Settings, UsageError
from sdaeverify.commands import (
    ExitCode,
    class_summary,
    code_of_verdicts,
    codes_in_words,
    conclude,
    empty_table,
    load_and_warn,
    options,
    output,
    print_texts,
    require_run_folder,
    save_results,
    visible,
    write_text,
)
from sdaeverify.measuring import Verdict
from sdaeverify.studying import select_measures, select_schemes

from .class_row import ClassRow
from .modified_equations import modified_of
from .order_report import MOST_MOTIONS, OrderReport
from .order_tests import class_work
from .trees.conditions import Condition
from .trees.grow import picture
from .trees.modified.lines import lines_of_equation, record_of_equation

HEADINGS = ("class", "motions", "claim", "order", "held", "verdict")
CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.NOTHING, ExitCode.PLUGIN)


@click.command(epilog=codes_in_words(*CODES), short_help="Test the claims of schemes on classes of equations.")
@click.argument("schemes", nargs=-1, required=True, metavar="SCHEME...")
@options.once("--class", "classes", metavar="NAMES", help="Classes, separated by commas.  [default: all]")
@options.once(
    "--motions",
    type=click.IntRange(1, MOST_MOTIONS),
    help="Number of Brownian motions.  [default: 3; with --modified 2]",
)
@options.once("--weight", type=int, help="Largest weight of trees.  [default: 2 p + 1 for a claimed order p]")
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each row.")
@click.option("--modified", is_flag=True, help="Show the equations that the schemes solve to one order more.")
@options.once("--problem", type=options.PLACE, metavar="OUT.py", help="Write a problem on which a claim is refuted.")
@options.run_folder
@options.plugins
def orders(
    schemes: tuple[str, ...],
    plugins: tuple[str, ...],
    as_json: bool,
    modified: bool,
    problem: Path | None,
    **asked: Any,
) -> ExitCode:
    """Test the claims of schemes on classes of equations.

    One step on an equation whose components are rooted trees gives every elementary weight. A claim is verified for a
    class, or refuted by a tree: f is the drift, b1, b2, ... are the columns of the diffusion, t is time. Langevin
    dynamics also have positions q, friction d and the momentum p before the step, index-1 equations constraints u.
    For constrained mechanics, constrained Langevin dynamics and delay equations, random members are drawn. With
    --modified no claim is tested, and the modified equations are shown, which the schemes solve to one order more.
    """
    registry, out = load_and_warn(plugins), asked.pop("out")
    asked = {name: value for name, value in asked.items() if value is not None}
    if modified:
        if out is not None:
            raise UsageError("contradictory options: --out saves verdicts, and --modified gives none")
        return _show_modified(select_schemes(registry, schemes), problem, as_json=as_json, **asked)
    chosen, measures = select_schemes(registry, schemes), select_measures(registry)
    if out is not None:
        require_run_folder(out)
    reports = [OrderReport.of(scheme, measures, **asked) for scheme in chosen]
    rows = [row for report in reports for row in report.rows]
    kept = [] if out is None else [save_results(out, class_work(rows, chosen, measures), registry, Settings())]
    if problem is not None:
        _write_problem(reports, problem)
    if as_json:
        _print_json([_told(row) for row in rows])
        return code_of_verdicts(row.verdict for row in rows)
    console = output()
    shown = (row for row in rows if row.verdict is not Verdict.NOT_APPLICABLE)
    for scheme, own in _grouped(shown, lambda row: row.scheme).items():
        # Names with parameters are long, so they get a separate line above the table.
        print_texts(console, [Text(visible(scheme), style="bold")])
        console.print(_table(own), Text())
    print_texts(console, _lines(rows))
    print_texts(console, [*class_summary([row.cells for row in rows]), *kept])
    return conclude(code_of_verdicts(row.verdict for row in rows))


def _show_modified(schemes: Sequence[Scheme], problem: Path | None, *, as_json: bool, **asked: Any) -> ExitCode:
    """Print the modified equations of schemes for the classes they solve, and return the exit code.

    Raises
    ------
    UsageError
        If a problem file is given, or a name or number is invalid.
    """
    if problem is not None:
        raise UsageError("contradictory options: --problem needs a refuted claim, and --modified tests none")
    found = [each for scheme in schemes for each in modified_of(scheme, **asked)]
    shown = [each for each in found if each.solves] or found
    if as_json:
        _print_json([record_of_equation(each) for each in found])
    else:
        print_texts(output(), [line for each in shown for line in (*lines_of_equation(each), "")])
    return ExitCode.OK if any(each.solves for each in found) else ExitCode.NOTHING


def _write_problem(reports: Sequence[OrderReport], file: Path) -> None:
    """Write a problem file of the first failing condition or random member that refutes a claim.

    Raises
    ------
    UsageError
        If no claim is refuted.
    """
    for report in reports:
        refuted: list[Condition | ClassRow] = [*report.failing, *report.refuted_members]
        if refuted:
            write_text(report.to_problem(refuted[0]), file)
            return
    raise UsageError(f"no claim is refuted: there is no problem to be written into {file}")


def _lines(rows: Sequence[ClassRow]) -> Iterator[str]:
    """Yield the lines below the table: premises, reasons, trees of failing conditions."""
    for note, some in _grouped(rows, lambda row: f"{row.scheme}: {row.premise}").items():
        yield f"{visible(note)} ({', '.join(dict.fromkeys(row.kind for row in some))})"
    for row in rows:
        if row.verdict is Verdict.REFUTED and row.first:
            yield ""
            yield from _failing(row)


def _grouped(rows: Iterable[ClassRow], key: Callable[[ClassRow], str]) -> dict[str, list[ClassRow]]:
    found: dict[str, list[ClassRow]] = {}
    for row in rows:
        found.setdefault(key(row), []).append(row)
    return found


def _print_json(value: object) -> None:
    click.echo(json.dumps(value, indent=2))


def _table(rows: Iterable[ClassRow]) -> Table:
    table = empty_table(*HEADINGS)
    for row in rows:
        table.add_row(*(Text(visible(cell)) for cell in _cells(row)))
    return table


def _cells(row: ClassRow) -> tuple[str, ...]:
    held = f"{row.held}/{row.of}" if row.of else ""
    claim, order = ("" if isnan(value) else f"{value:.3g}" for value in (row.claim, row.order))
    return (row.kind, str(row.motions), f"{row.measure} {claim}".rstrip(), order, held, row.verdict.value)


def _failing(row: ClassRow) -> Iterator[str]:
    assert row.first is not None
    found, wanted = row.first.texts
    if row.mistake:
        yield f"{visible(row.scheme)}, {row.kind}: {row.mistake}"
    yield f"{visible(row.scheme)}, {row.kind}, {row.measure}: {row.first.name}: found {found}, wanted {wanted}"
    for tree in row.first.forest:
        yield from (f"    {line}" for line in picture(tree))


def _told(row: ClassRow) -> dict[str, object]:
    numbers = {name: None if isnan(value) else value for name, value in (("order", row.order), ("claim", row.claim))}
    return {**row.cells, **numbers, "trees": [picture(tree) for tree in row.first.forest] if row.first else []}
