"""Short representation of a result at a prompt and in a notebook."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from io import StringIO

import pandas as pd
from rich.console import Console

from ..contracts.settings import Settings
from ..errors import UsageError
from .cells import Row, text
from .plain import visible, wrap_text
from .sentences import ATTENTION, counts_of, ending, in_cells, overview
from .verdict_row import VerdictRow

WIDTH = 80
# Largest number of table rows in a notebook.
MOST = 30
MORE = "print it; .verdicts .levels .details(measure) .cell(scheme, problem) .plot"


@dataclass(frozen=True)
class CellView:
    """Findings on a scheme and a problem.

    Attributes
    ----------
    scheme, problem : str
        Labels.
    rows : tuple of VerdictRow
    absent : tuple of mapping
        Rows of measures that do not apply.
    """

    scheme: str
    problem: str
    rows: tuple[VerdictRow, ...]
    absent: tuple[Row, ...]

    @classmethod
    def of(cls, rows: Sequence[VerdictRow], absent: Sequence[Row], scheme: str, problem: str) -> "CellView":
        """Select the rows of a cell.

        Parameters
        ----------
        rows : sequence of VerdictRow
            Rows of claimed or measured quantities.
        absent : sequence of Row
            Rows of cells that do not apply, with reasons.
        scheme, problem : str
            Labels, as in the tables.

        Raises
        ------
        UsageError
            If there is no such cell.
        """
        found = tuple(row for row in rows if (row.scheme, row.problem) == (scheme, problem))
        lacking = tuple(row for row in absent if (row["scheme"], row["problem"]) == (scheme, problem))
        if not (found or lacking):
            raise UsageError(f"the result has no cell of {scheme!r:.200} on {problem!r:.200}")
        return cls(scheme, problem, found, lacking)

    def __repr__(self) -> str:
        console = Console(file=StringIO(), width=WIDTH)
        with console.capture() as shown:
            console.print(*overview(self.rows))
        return "\n".join([shown.get().strip(), *_absent(self.absent)])

    def _repr_html_(self) -> str:
        absent = "".join(f"<p>{escape(line)}</p>" for line in _absent(self.absent))
        return f"<h4>{escape(visible(f'{self.scheme} on {self.problem}'))}</h4>{_table(self.rows)}{absent}"


def result_text(rows: Sequence[VerdictRow], absent: Sequence[Row] = ()) -> str:
    """Return a result for a prompt: counts, quantities that need attention, schemes by measure."""
    return "\n".join(line.plain for line in ending(counts_of(rows, absent), rows, [], WIDTH)).rstrip()


def result_in_brief(rows: Sequence[VerdictRow], absent: Sequence[Row], settings: Settings) -> str:
    """Return a short description of a result: counts, cells, settings, and where to find more.

    Parameters
    ----------
    rows : sequence of VerdictRow
    absent : sequence of mapping
        Cells that do not apply.
    settings : Settings
        Settings of the run.
    """
    schemes, problems, measures = ({getattr(row, kind) for row in rows} for kind in ("scheme", "problem", "measure"))
    named = (
        f"{len(found)} {kind}{'s' * (len(found) != 1)}"
        for found, kind in ((schemes, "scheme"), (problems, "problem"))
    )
    of = f"{' on '.join(named)}: {', '.join(sorted(measures)) or 'nothing measured'}"
    steps = f"{settings.steps[0]}..{settings.steps[-1]} steps"
    lines = [counts_of(rows, absent), of, f"{settings.paths} paths, {steps}, seed {settings.seed}", MORE]
    return "\n".join(visible(line) for text in lines for line in wrap_text(text, WIDTH))


def result_html(rows: Sequence[VerdictRow], absent: Sequence[Row] = ()) -> str:
    """Return a result for a notebook: counts, and a table with rows that need attention first."""
    sentence = escape(counts_of(rows, absent))
    worst = sorted(rows, key=lambda row: row.verdict not in ATTENTION)
    more = f"<p>and {len(worst) - MOST} more: .verdicts has all</p>" if len(worst) > MOST else ""
    return f"<p><b>{sentence}</b></p>{_table(worst[:MOST])}{more}"


def _absent(rows: Sequence[Row]) -> list[str]:
    return [visible(f"{text(row, 'measure')} does not apply: {text(row, 'reason')}") for row in rows]


def _table(rows: Sequence[VerdictRow]) -> str:
    with pd.option_context("display.max_colwidth", None):
        return str(pd.DataFrame(map(in_cells, rows)).to_html(index=False, border=0))
