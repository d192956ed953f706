"""Verdicts as a table for a paper, in LaTeX with booktabs or in Markdown, with symbols and a caption."""

from collections.abc import Callable, Iterable, Sequence
from math import isfinite, isnan
from typing import NamedTuple

from ...errors import UsageError
from ..plain import escape, visible
from ..sentences import SYMBOLS, estimate_in_words
from ..verdict_row import ORDER, Interval, VerdictRow

# Signs of verdicts in LaTeX; \checkmark is of amssymb.
SIGNS = {
    "refuted": r"$\times$", "diverged": "!", "error": "!", "inconclusive": "?", "not_run": r"$\dots$",
    "verified": r"$\checkmark$", "out_of_scope": r"$\circ$", "not_applicable": r"$\cdot$",
}  # fmt: skip
MEANINGS = {"out_of_scope": "no claim", "not_run": "not run", "diverged": "failed", "error": "failed"}
HEADINGS = ("", "scheme", "problem", "quantity", "claim", "one step", "along paths", "other value", "tier")
LATEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': r"\textquotedbl{}", "≥": r"$\geq$", "≤": r"$\leq$",
}  # fmt: skip
# Characters missing from the LaTeX font are shown by code point, so that a table compiles with pdflatex.
PACKAGES = r"% needs \usepackage[T1]{fontenc}, \usepackage{amssymb}, \usepackage{booktabs}"
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
        """Return a LaTeX table with caption and label, which floats unless it is longer than a page."""
        lines = [" & ".join([SIGNS[first], *map(latex, rest)]) + r" \\" for first, *rest in self._shown]
        columns = "c" + "l" * (len(self._headings) - 1)
        heading = [r"\toprule", " & ".join(map(latex, self._headings)) + r" \\", r"\midrule"]
        caption = rf"\caption{{{latex(self.caption)} {self._legend(SIGNS.__getitem__)}}}\label{{tab:sdaeverify}}"
        if len(lines) > PAGE:
            start = [rf"{PACKAGES}, \usepackage{{longtable}}", rf"\begin{{longtable}}{{{columns}}}"]
            head = [caption + r" \\", *heading, r"\endfirsthead", *heading, r"\endhead", r"\bottomrule", r"\endfoot"]
            return "\n".join([*start, *head, *lines, r"\end{longtable}", ""])
        start = [PACKAGES, r"\begin{table}", r"\centering", caption, rf"\begin{{tabular}}{{{columns}}}"]
        end = [r"\bottomrule", r"\end{tabular}", r"\end{table}", ""]
        return "\n".join([*start, *heading, *lines, *end])

    def to_markdown(self) -> str:
        """Return a Markdown table, followed by its caption."""
        lines = [[_sign(first), *map(escape, rest)] for first, *rest in self._shown]
        table = [self._headings, ["---"] * len(self._headings), *lines]
        rows = (f"| {' | '.join(line)} |" for line in table)
        return "\n".join([*rows, "", f"{escape(self.caption)} {self._legend(_sign)}", ""])

    @property
    def _columns(self) -> list[int]:
        """Indices of columns that are not entirely empty."""
        return [place for place in range(len(HEADINGS)) if any(row[place] for row in self.cells)]

    @property
    def _headings(self) -> list[str]:
        return [HEADINGS[place] for place in self._columns]

    @property
    def _shown(self) -> list[list[str]]:
        return [[row[place] for place in self._columns] for row in self.cells]

    def _legend(self, sign: Callable[[str], str]) -> str:
        found = {row[0] for row in self.cells}
        told = dict.fromkeys(f"{sign(each)} {MEANINGS.get(each, each)}" for each in SYMBOLS if each in found)
        return f"{', '.join(told)}."


def latex(text: str) -> str:
    """Escape a text for LaTeX, including characters missing from the font."""
    return "".join(LATEX.get(letter, letter) if letter in LATEX or letter.isascii() else _by_number(letter)
                   for letter in visible(text))  # fmt: skip


def _by_number(letter: str) -> str:
    # Letters of Latin-1, such as umlauts, are in T1 fonts.
    return letter if letter.isalpha() and ord(letter) < 0x100 else rf"\texttt{{U+{ord(letter):04X}}}"


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
