"""A comparison as records, as a table for a terminal, and in words."""

from collections import Counter
from collections.abc import Iterator, Sequence
from math import isfinite

from rich.table import Table
from rich.text import Text

from ...report.plain import empty_table, visible
from .cells import Comparison, Omitted
from .changes import Change, Changed

Rows = Sequence[tuple[Comparison, Changed]]

STYLES = {Change.WORSE: "bold red", Change.UNDECIDED: "yellow", Change.BETTER: "green", Change.SAME: "dim"}
WORDS = {
    Change.WORSE: "worse",
    Change.BETTER: "better",
    Change.SAME: "the same",
    Change.UNDECIDED: "undecided",
}
HEADINGS = ("scheme", "problem", "measure", "quantity", "factor", "interval", "verdict")
MOST_TOLD = 20


def records(rows: Rows) -> list[dict[str, object]]:
    """Return one record for each quantity; a number that is not finite is none in JSON."""
    return [
        {
            **dict(zip(HEADINGS[:4], compared, strict=False)),
            "factor": _number(changed.factor),
            "ci_low": _number(changed.low),
            "ci_high": _number(changed.high),
            "verdict": str(changed.change),
            "levels": compared.found.levels,
            "paths": compared.paths,
            "reason": compared.found.reason,
        }
        for compared, changed in rows
    ]


def comparison_table(rows: Rows) -> Table:
    """Return the factors, the worst verdicts first and the largest factors first in each."""
    table = empty_table(*HEADINGS)
    order = list(STYLES)
    for compared, changed in sorted(rows, key=lambda row: (order.index(row[1].change), -row[1].factor)):
        interval = f"{changed.low:.3f} to {changed.high:.3f}" if compared.found.sampled else compared.found.reason
        texts = (*compared[:4], f"{changed.factor:.3f}", interval)
        table.add_row(*(Text(visible(text)) for text in texts), Text(changed.change, style=STYLES[changed.change]))
    return table


def counts(rows: Rows) -> str:
    """Return in one sentence how many quantities became what."""
    found = Counter(changed.change for _, changed in rows)
    parts = (f"{found[change] or 'none'} {words}" for change, words in WORDS.items())
    return f"{len(rows)} {'quantity' if len(rows) == 1 else 'quantities'} compared: {', '.join(parts)}"


def left_out(omitted: Sequence[Omitted]) -> Iterator[str]:
    """Yield what is not compared, a line for each reason."""
    grouped: dict[str, list[Omitted]] = {}
    for each in omitted:
        grouped.setdefault(each.reason, []).append(each)
    for reason, cells in list(grouped.items())[:MOST_TOLD]:
        first = cells[0]
        what = f"{first.scheme} on {first.problem}, {first.measure} {first.quantity}".rstrip(", ")
        more = f" and {len(cells) - 1} more" if len(cells) > 1 else ""
        yield visible(f"not compared: {what}{more}: {reason}")
    if len(grouped) > MOST_TOLD:
        yield f"and {len(grouped) - MOST_TOLD} more reasons, see --json"


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
