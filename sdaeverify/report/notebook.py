"""A result at a prompt and in a notebook: a short table, not all there is."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from math import isnan

from ..errors import UsageError
from .plain import visible
from .reading import Row, read_row, text
from .sentences import (
    ATTENTION,
    Pair,
    claim_in_words,
    counts_of,
    ending,
    estimate_in_words,
    interval,
    mark,
    quantity_lines,
)

WIDTH = 80
# Rows of a table in a notebook.
MOST = 30
HEADINGS = ("", "scheme", "problem", "quantity", "claim", "one step", "along paths", "decided by", "why")


@dataclass(frozen=True)
class CellView:
    """What was found of a scheme on a problem.

    Attributes
    ----------
    scheme, problem : str
        Labels.
    rows, absent : tuple of mapping
        Of the verdicts, and of what does not apply.
    """

    scheme: str
    problem: str
    rows: tuple[Row, ...]
    absent: tuple[Row, ...]

    @classmethod
    def of(cls, rows: Sequence[Row], absent: Sequence[Row], scheme: str, problem: str) -> "CellView":
        """Return the view of a cell.

        Parameters
        ----------
        rows : sequence of Row
            Quantities that were claimed or measured.
        absent : sequence of Row
            Cells that were not applicable, with reasons.
        scheme, problem : str
            Labels, as in the tables.

        Raises
        ------
        UsageError
            If there is no such cell.
        """
        found = [[r for r in all_ if (r["scheme"], r["problem"]) == (scheme, problem)] for all_ in (rows, absent)]
        if not any(found):
            raise UsageError(f"the result has no cell of {scheme!r:.200} on {problem!r:.200}")
        return cls(scheme, problem, *map(tuple, found))

    def __repr__(self) -> str:
        title = visible(f"{self.scheme} on {self.problem}")
        lines = [line.text for pair in _pairs(self.rows) for line in quantity_lines(pair, WIDTH, brief=True)]
        return "\n".join([title, *lines, *_absent(self.absent)])

    def _repr_html_(self) -> str:
        absent = "".join(f"<p>{escape(line)}</p>" for line in _absent(self.absent))
        return f"<h4>{escape(visible(f'{self.scheme} on {self.problem}'))}</h4>{_table(_pairs(self.rows))}{absent}"


def result_text(rows: Sequence[Row], absent: Sequence[Row] = ()) -> str:
    """Return a result for a prompt: the counts, what needs attention, the schemes by measure."""
    return "\n".join(line.text for line in ending(counts_of(rows, absent), _pairs(rows), [], WIDTH)).rstrip()


def result_html(rows: Sequence[Row], absent: Sequence[Row] = ()) -> str:
    """Return a result for a notebook: the counts, and a table with what needs attention first."""
    sentence = escape(counts_of(rows, absent))
    pairs = sorted(_pairs(rows), key=lambda pair: pair[1].verdict not in ATTENTION)
    more = f"<p>and {len(pairs) - MOST} more: .verdicts has all</p>" if len(pairs) > MOST else ""
    return f"<p><b>{sentence}</b></p>{_table(pairs[:MOST])}{more}"


def _pairs(rows: Sequence[Row]) -> list[Pair]:
    return [(row, read_row(row)) for row in rows]


def _absent(rows: Sequence[Row]) -> list[str]:
    return [visible(f"{text(row, 'measure')} does not apply: {text(row, 'reason')}") for row in rows]


def _table(pairs: Sequence[Pair]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in HEADINGS)
    rows = ("".join(f"<td>{escape(visible(cell))}</td>" for cell in _cells(pair)) for pair in pairs)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cells(pair: Pair) -> tuple[str, ...]:
    row, reading = pair
    local = "" if isnan(reading.local_order) else f"{reading.local_order:.2f}"
    along = interval(reading.path) or (estimate_in_words(reading) if not local else "")
    names = (text(row, "scheme"), text(row, "problem"), f"{text(row, 'measure')} {text(row, 'quantity')}".strip())
    symbol = f"{mark(reading.verdict)} {reading.verdict}"
    return symbol, *names, claim_in_words(reading), local, along, reading.decided_by, reading.reason
