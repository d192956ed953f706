"""Verdicts as a table for a paper, in LaTeX with booktabs or in Markdown, with symbols and a caption."""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise, takewhile
from math import isfinite, isnan
from typing import NamedTuple

from ...errors import UsageError
from ..plain import escape
from ..sentences import SYMBOLS, estimate_in_words
from ..verdict_row import ORDER, Interval, VerdictRow
from .latex import break_lines, column_types, escape_latex, set_indices

# Signs of verdicts in LaTeX; \checkmark is of amssymb.
SIGNS = {
    "refuted": r"$\times$", "diverged": "!", "error": "!", "inconclusive": "?", "not_run": r"$\dots$",
    "verified": r"$\checkmark$", "out_of_scope": r"$\circ$", "not_applicable": r"$\cdot$",
}  # fmt: skip
MEANINGS = {
    "out_of_scope": "no claim",
    "not_run": "not run",
    "not_applicable": "not applicable",
    "diverged": "failed",
    "error": "failed",
}
# Columns whose words are broken over lines if a table is too wide, and one whose indices are set as such.
BREAKABLE = {"scheme", "problem", "quantity", "other value"}
QUANTITY = "quantity"
# Columns that the caption replaces if all rows have the same value.
NAMES = ("scheme", "problem")
HEADINGS = ("", "scheme", "problem", "quantity", "claim", "one step", "along paths", "other value", "tier")
# Characters missing from the LaTeX font are shown by code point, so that a table compiles with pdflatex.
PACKAGES = r"% needs \usepackage[T1]{fontenc}, \usepackage{array}, \usepackage{amssymb}, \usepackage{booktabs}"
LONG = r"\usepackage{longtable}, which needs a page of one column"
# Rows that fit on a page; longer tables use the package longtable, which breaks across pages.
PAGE = 40


class PaperTable(NamedTuple):
    """A table of verdicts.

    Attributes
    ----------
    cells : tuple of tuple of str
        Rows of texts in the order of `HEADINGS`; the first text is the verdict, which is replaced by its symbol.
    caption : str
    """

    cells: tuple[tuple[str, ...], ...]
    caption: str

    @classmethod
    def of(cls, rows: Sequence[VerdictRow], caption: str) -> "PaperTable":
        """Create the table from rows of verdicts.

        Parameters
        ----------
        rows : sequence of VerdictRow
        caption : str
            Description of the method; a legend of the symbols is appended.

        Raises
        ------
        UsageError
            If there are no rows.
        """
        if not rows:
            raise UsageError("no table: the result has no row of these names")
        return cls(tuple(tuple(_cells(row)) for row in rows), caption)

    def to_latex(self) -> str:
        r"""Return a table with caption and label, which floats unless it is longer than a page.

        It fits a line of 345 points, the width of the class article: in ``\footnotesize``, with the lines of long
        names broken, and in ``\scriptsize`` if that is not narrow enough.
        """
        font, columns = column_types(self._texts[1:], [heading in BREAKABLE for heading in self._headings[1:]])
        heading = [r"\toprule", " & ".join(map(escape_latex, self._headings)) + r" \\", r"\midrule"]
        told = escape_latex(f"{self.caption}{self._common}")
        caption = rf"\caption{{{told} {self._legend(SIGNS.__getitem__)}}}\label{{tab:sdaeverify}}"
        if len(self.cells) > PAGE:
            start = [f"{PACKAGES}, {LONG}", rf"\begingroup{font}", rf"\begin{{longtable}}{{c{columns}}}"]
            head = [caption + r" \\", *heading, r"\endfirsthead", *heading, r"\endhead", r"\bottomrule", r"\endfoot"]
            lines = map(self._latex_line, self._shown)
            return "\n".join([*start, *head, *lines, r"\end{longtable}", r"\endgroup", ""])
        start = [PACKAGES, r"\begin{table}", r"\centering", caption, rf"\smallskip{font}"]
        end = [r"\bottomrule", r"\end{tabular}", r"\end{table}", ""]
        lines = map(self._latex_line, self._without_repeats)
        return "\n".join([*start, rf"\begin{{tabular}}{{c{columns}}}", *heading, *lines, *end])

    def to_markdown(self) -> str:
        """Return a Markdown table, followed by its caption."""
        lines = [[_sign(first), *map(escape, rest)] for first, *rest in self._shown]
        table = [self._headings, ["---"] * len(self._headings), *lines]
        rows = (f"| {' | '.join(line)} |" for line in table)
        return "\n".join([*rows, "", f"{escape(self.caption + self._common)} {self._legend(_sign)}", ""])

    @property
    def _columns(self) -> list[int]:
        """Columns that are not empty throughout, without those that the caption replaces."""
        return [
            place
            for place, heading in enumerate(HEADINGS)
            if any(row[place] for row in self.cells) and heading not in self._same
        ]

    @property
    def _same(self) -> dict[str, str]:
        """Scheme and problem where all of several rows have the same one."""
        values = {name: {row[HEADINGS.index(name)] for row in self.cells} for name in NAMES}
        return {name: min(found) for name, found in values.items() if len(found) == 1 < len(self.cells)}

    @property
    def _common(self) -> str:
        return "".join(f" {name.capitalize()}: {label}." for name, label in self._same.items())

    @property
    def _headings(self) -> list[str]:
        return [HEADINGS[place] for place in self._columns]

    @property
    def _shown(self) -> list[list[str]]:
        return [[row[place] for place in self._columns] for row in self.cells]

    @property
    def _without_repeats(self) -> list[list[str]]:
        """Rows in which names of schemes and problems stand where they change."""
        shown = self._shown
        names = [place for place, heading in enumerate(self._headings) if heading in NAMES]
        rows = [[*row] for row in shown]
        for before, row in pairwise(range(len(shown))):
            for place in takewhile(lambda at: shown[before][at] == shown[row][at], names):  # noqa: B023 - used at once
                rows[row][place] = ""
        return rows

    @property
    def _texts(self) -> list[tuple[str, ...]]:
        """Cells of each column below its heading."""
        return [*zip(self._headings, *self._shown, strict=True)]

    def _latex_line(self, row: Sequence[str]) -> str:
        sign, *rest = row
        cells = (
            set_indices(cell)
            if heading == QUANTITY
            else break_lines(cell)
            if heading in BREAKABLE
            else escape_latex(cell)
            for heading, cell in zip(self._headings[1:], rest, strict=True)
        )
        return " & ".join([SIGNS[sign], *cells]) + r" \\"

    def _legend(self, sign: Callable[[str], str]) -> str:
        found = {row[0] for row in self.cells}
        told = dict.fromkeys(f"{sign(each)} {MEANINGS.get(each, each)}" for each in SYMBOLS if each in found)
        return f"{', '.join(told)}."


def _sign(verdict: str) -> str:
    return SYMBOLS[verdict][0]


def _cells(row: VerdictRow) -> Iterable[str]:
    yield row.verdict
    yield row.scheme
    yield row.problem
    yield f"{row.measure} {row.quantity}".strip()
    yield row.claim if isnan(row.claimed_order) else f"order ≥ {row.claimed_order}"
    yield "" if isnan(row.local_order) else f"{row.local_order:.2f}" if isfinite(row.local_order) else "exact"
    yield _interval(row.path)
    yield _value(row)
    yield row.decided_by


def _interval(order: Interval) -> str:
    if not order.known:
        return ""
    if isfinite(order.low) and not isfinite(order.high):
        return f"≥ {order.low:.2f}"
    ends = f" [{order.low:.2f}, {order.high:.2f}]" if isfinite(order.low) else ""
    return f"{order.value:.2f}{ends}"


def _value(row: VerdictRow) -> str:
    """Return the estimate other than an order, with its meaning and unit; empty if there is none."""
    if not row.estimate.known or not isnan(row.local_order) or row.path.known:
        return ""
    return _interval(row.estimate) if ORDER in row.value_of else estimate_in_words(row)
