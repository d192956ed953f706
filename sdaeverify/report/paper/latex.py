"""Text and columns of a LaTeX table: escapes, and columns whose lines break."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from ..plain import visible


class Font(NamedTuple):
    r"""A size of the text of a table.

    Attributes
    ----------
    command : str
    character : float
        Mean width of a character of Computer Modern, in points: 0.54 of the size; a digit takes 0.53.
    between : float
        Space between two columns in points: twice ``\tabcolsep``.
    """

    command: str
    character: float
    between: float


# The second is for tables too wide for the first even with their lines broken.
FONTS = (
    Font(r"\footnotesize\setlength{\tabcolsep}{4pt}", 4.3, 8.0),
    Font(r"\scriptsize\setlength{\tabcolsep}{2.5pt}", 3.8, 5.0),
)
ESCAPES = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': r"\textquotedbl{}", "≥": r"$\geq$", "≤": r"$\leq$",
}  # fmt: skip
# A line of the class article at 10 points, in points.
LINE = 345.0
# A line may break behind each of these; LaTeX breaks at spaces and hyphens itself.
BREAKS = "[,=_"
PIECES = re.compile(rf"[^\s\-{re.escape(BREAKS)}]*[\-{re.escape(BREAKS)}]?")
INDEX = re.compile(r"([_^])(\d+)\b")
RAISED = {"_": r"\textsubscript", "^": r"\textsuperscript"}


def escape_latex(text: str) -> str:
    """Return a text for LaTeX, with special characters and characters outside the font escaped."""
    return "".join(
        ESCAPES.get(letter, letter) if letter in ESCAPES or letter.isascii() else _by_number(letter)
        for letter in visible(text)
    )


def set_indices(text: str) -> str:
    """Return the name of a quantity for LaTeX: numbers after ``_`` and ``^`` are subscripts and superscripts."""
    parts = INDEX.split(text)
    plain, signs, numbers = parts[::3], parts[1::3], parts[2::3]
    raised = [f"{RAISED[sign]}{{{number}}}" for sign, number in zip(signs, numbers, strict=True)]
    return "".join(escape_latex(before) + after for before, after in zip(plain, [*raised, ""], strict=True))


def break_lines(text: str) -> str:
    """Return the text of a cell for LaTeX, where the line may break after ``[``, ``,``, ``=`` and ``_``."""
    return "".join(escape_latex(letter) + (r"\allowbreak{}" if letter in BREAKS else "") for letter in text)


def column_types(columns: Sequence[Sequence[str]], breakable: Sequence[bool]) -> tuple[str, str]:
    r"""Return the command for the font, and the columns of a ``tabular`` that is as wide as a page or narrower.

    Parameters
    ----------
    columns : sequence of sequence of str
        Cells of each column, its heading among them.
    breakable : sequence of bool
        Which columns hold words. If lines are too long, these become paragraphs at least as wide as their longest
        piece, and share the remaining width in proportion to their missing width; the others are ``l``.
    """
    lengths = [max(map(len, cells)) for cells in columns]
    pieces = [
        max(len(piece) for cell in cells for piece in PIECES.findall(cell)) if breaks else length
        for cells, length, breaks in zip(columns, lengths, breakable, strict=True)
    ]
    font, spare = _font_for(len(columns), sum(pieces))
    lack = sum(lengths) - sum(pieces)
    if lack <= spare:
        return font.command, "l" * len(columns)
    widths = [piece + spare * (length - piece) / lack for piece, length in zip(pieces, lengths, strict=True)]
    kinds = zip(widths, breakable, strict=True)
    return font.command, "".join(_paragraph(width * font.character) if breaks else "l" for width, breaks in kinds)


def _font_for(columns: int, characters: int) -> tuple[Font, float]:
    """Return the largest font in which a line holds the characters, or the smallest, and how many more it holds."""
    spare = 0.0
    for font in FONTS:
        spare = (LINE - font.between * (columns + 1)) / font.character - characters
        if spare >= 0.0:
            break
    return font, max(spare, 0.0)


def _paragraph(points: float) -> str:
    return rf">{{\raggedright\arraybackslash}}p{{{points:.0f}pt}}"


def _by_number(letter: str) -> str:
    # Letters of Latin-1, umlauts above all, are in T1 fonts.
    return letter if letter.isalpha() and ord(letter) < 0x100 else rf"\texttt{{U+{ord(letter):04X}}}"
