"""Rows of solvers as a table in a terminal and as records for JSON."""

from collections import Counter
from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from math import isfinite

from rich.table import Table
from rich.text import Text

from sdaeverify.commands import empty_table, output, print_texts, visible
from sdaeverify.measuring import Verdict

from .pairs import Row

STYLES = {Verdict.VERIFIED: "green", Verdict.REFUTED: "bold red", Verdict.INCONCLUSIVE: "yellow"}


def print_rows(found: Sequence[Row], why: Sequence[str], silent: AbstractSet[Verdict]) -> None:
    """Print the table, the reasons, why pairs cannot be measured, and the counts of verdicts.

    Parameters
    ----------
    found : sequence of Row
    why : sequence of str
        A line for each pair that cannot be measured.
    silent : set of Verdict
        Verdicts whose reasons are not printed.
    """
    console = output(unbroken=True)
    for pair in dict.fromkeys(map(_pair, found)):
        print_texts(console, [pair])
        console.print(_table([row for row in found if _pair(row) == pair]), "")
    print_texts(console, (*_reasons(found, silent), *([""] if why else []), *why, "", _counts(found)))


def records(found: Sequence[Row]) -> Iterator[dict[str, object]]:
    """Yield the rows as records for JSON, in which numbers that are not finite are null."""
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


def _pair(row: Row) -> str:
    return f"{row.cell.solver.label} on {row.cell.label}"


def _table(found: Sequence[Row]) -> Table:
    """Return the table of a solver on a problem; without their names its columns fit a narrow terminal."""
    table = empty_table("about", "claim", "found", "verdict")
    for row in found:
        verdict = row.finding.verdict
        texts = (_about(row), str(row.finding.claim or ""), _estimate(row))
        table.add_row(*(Text(visible(text)) for text in texts), Text(verdict.value, style=STYLES.get(verdict, "")))
    return table


def _about(row: Row) -> str:
    return f"{row.measure} of {row.finding.quantity}" if row.finding.quantity else row.measure


def _estimate(row: Row) -> str:
    low, high = row.finding.low, row.finding.high
    return f"{low:.3g} to {high:.3g}" if isfinite(low) and isfinite(high) else ""


def _reasons(found: Sequence[Row], silent: AbstractSet[Verdict]) -> Iterator[str]:
    for row in found:
        if row.finding.verdict not in silent:
            verdict = row.finding.verdict.value
            yield f"{_pair(row)}, {_about(row)}: {verdict}: {row.finding.reason}"


def _counts(found: Sequence[Row]) -> str:
    counts = Counter(row.finding.verdict.value for row in found)
    return ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())) or "no solver and problem fit"
