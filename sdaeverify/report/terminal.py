"""Results for a terminal: a table of schemes and problems, drifts and windows in words."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import product

from rich.table import Table
from rich.text import Text

from ..contracts.finding import Verdict
from ..study import CellResult, Plan
from .plain import empty_table, visible
from .sentences import SYMBOLS as TEXT_SYMBOLS
from .sentences import counts_in_words

Cells = dict[tuple[str, str], dict[str, Counter[Verdict]]]

# Worst first: the order in which verdicts stand in a cell and in a sentence.
SYMBOLS = {Verdict(name): shown for name, shown in TEXT_SYMBOLS.items()}
DRIFTS = {
    "growing as h tends to 0": "{scheme} drifts off {quantity} on {where}, the more the smaller h is",
    "tolerance-limited": "{scheme} keeps {quantity} on {where} to a tolerance only",
    "constant": "{scheme} drifts off {quantity} on {where} by as much at every h",
}
GAP = 2
NARROW = 20


def summary_tables(results: Iterable[CellResult], width: int, *, plain: bool = False) -> list[Table]:
    """Return the matrix: a row for each scheme, a column for each problem, several tables where it is too wide.

    Parameters
    ----------
    results : iterable of CellResult
    width : int
        Columns of the terminal.
    plain : bool
        Whether only ASCII can be shown.
    """
    cells = _count_verdicts(results)
    schemes, problems = sorted({scheme for scheme, _ in cells}), list(dict.fromkeys(problem for _, problem in cells))
    # A run that was merged has not crossed everything with everything.
    texts = {place: _cell(cells.get(place, {}), plain=plain) for place in product(schemes, problems)}
    widths = [_column_width(problem, [texts[scheme, problem] for scheme in schemes]) for problem in problems]
    longest = max(map(len, schemes))
    label = longest if longest + sum(GAP + column for column in widths) <= width else min(longest, NARROW)
    tables = []
    for chunk in _chunks(list(zip(problems, widths, strict=True)), width - label):
        table = empty_table()
        table.add_column("", width=label)
        for problem, column in chunk:
            table.add_column(break_label(problem, column), width=column)
        for scheme in schemes:
            table.add_row(break_label(scheme, label), *(texts[scheme, problem] for problem, _ in chunk))
        tables.append(table)
    return tables


def legend(*, plain: bool = False) -> Text:
    """Return what the symbols of the table mean."""
    words = {
        Verdict.VERIFIED: "verified",
        Verdict.REFUTED: "refuted",
        Verdict.INCONCLUSIVE: "inconclusive",
        Verdict.DIVERGED: "failed",
        Verdict.OUT_OF_SCOPE: "no claim",
        Verdict.NOT_APPLICABLE: "not applicable",
    }
    return Text("  ").join(
        Text.assemble(_symbol(verdict, plain=plain), f" {word}") for verdict, word in words.items()
    )


def counts(results: Iterable[CellResult]) -> str:
    """Return in one sentence how many quantities got which verdict."""
    return counts_in_words(finding.verdict for result in results for finding in result.findings)


def drifts(results: Iterable[CellResult]) -> list[str]:
    """Return in words which scheme leaves which constraint on which problem, and how that depends on h."""
    return [visible(line) for result in results for line in _drifts(result)]


def windows(results: Iterable[CellResult]) -> list[str]:
    """Return in words for which step sizes second moments tend to 0, and how they grow for the equation."""
    return [
        visible(
            f"{result.cell.scheme.label} on {result.cell.spec.label}, {finding.quantity}: stable windows "
            f"{finding.details['windows']}; growth rate of the equation {finding.details['growth_rate']:.5g}"
        )
        for result in results
        for finding in result.findings
        if finding.details.get("windows")
    ]


def plan_table(plan: Plan) -> Table:
    """Return a row for each cell: what would be run, in which view, and why not."""
    table = empty_table()
    for heading in ("", "scheme", "problem", "measure", "view or reason"):
        table.add_column(heading)
    for cell in plan.cells:
        state = Text("run", style="green") if cell.verdict is None else Text(cell.verdict, style="dim")
        names = (cell.scheme.label, cell.spec.label, cell.measure.name, cell.reason or cell.view)
        table.add_row(state, *(Text(visible(name)) for name in names))
    return table


def break_label(label: str, width: int) -> Text:
    """Return a label in lines of at most some width, broken after hyphens and commas and before brackets."""
    lines = [""]
    for piece in re.split(r"(?<=[-,])|(?=\[)", visible(label)):
        if lines[-1] and len(lines[-1] + piece) > width:
            lines.append("")
        lines[-1] += piece
    return Text("\n".join(lines), overflow="fold")


def _drifts(result: CellResult) -> Iterator[str]:
    cell = result.cell
    where = f"{cell.spec.label} ({cell.view})" if cell.view else cell.spec.label
    kinds = [(str(finding.details.get("class", "")), finding) for finding in result.findings]
    if ordered := [finding for kind, finding in kinds if kind.startswith("order")]:
        names = " and ".join(finding.quantity for finding in ordered)
        orders = " and ".join(f"{finding.estimate:.2f}" for finding in ordered)
        yield f"{cell.scheme.label} drifts off {names} on {where} at order {orders} in h"
    for kind, finding in kinds:
        if kind in DRIFTS:
            yield DRIFTS[kind].format(scheme=cell.scheme.label, quantity=finding.quantity, where=where)


def _count_verdicts(results: Iterable[CellResult]) -> Cells:
    cells: Cells = {}
    for result in results:
        place = cells.setdefault((result.cell.scheme.label, result.cell.spec.label), {})
        count = place.setdefault(result.cell.measure.name, Counter())
        count.update(finding.verdict for finding in result.findings)
    return cells


def _cell(measures: dict[str, Counter[Verdict]], *, plain: bool) -> Text:
    lines = []
    for measure, found in sorted(measures.items()):
        if set(found) != {Verdict.NOT_APPLICABLE}:
            parts = [(_symbol(v, plain=plain), str(found[v])) for v in SYMBOLS if v in found]
            lines.append(Text(" ").join([Text(visible(measure)), *(Text.assemble(*part) for part in parts)]))
    return Text("\n").join(lines) if lines else _symbol(Verdict.NOT_APPLICABLE, plain=plain)


def _symbol(verdict: Verdict, *, plain: bool) -> Text:
    symbol, letter, style = SYMBOLS[verdict]
    return Text(letter if plain else symbol, style=style)


def _column_width(problem: str, cells: Iterable[Text]) -> int:
    pieces = re.split(r"(?<=[-,])|(?=\[)", visible(problem))
    lines = [line for cell in cells for line in cell.plain.split("\n")]
    return min(max(map(len, [*pieces, *lines])), NARROW)


def _chunks(columns: Sequence[tuple[str, int]], width: int) -> Iterator[list[tuple[str, int]]]:
    chunk: list[tuple[str, int]] = []
    for problem, column in columns:
        if chunk and sum(GAP + other for _, other in chunk) + GAP + column > width:
            yield chunk
            chunk = []
        chunk.append((problem, column))
    yield chunk
