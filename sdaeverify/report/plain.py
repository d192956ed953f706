"""Text and tables as every command shows them, whatever they are about, and the consoles that they go to."""

import os
import sys
from collections.abc import Iterable, Sequence
from textwrap import TextWrapper
from typing import IO

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..registry.foreign_code import unbounded

MORE, TOGETHER = "…", "\u00a0"
# Wider than any table: a line that is piped into another program is not broken.
UNBROKEN = 10_000


def visible(text: str) -> str:
    """Return a text with everything that cannot be seen, control characters above all, as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def empty_table(*headings: str) -> Table:
    """Return a table in the style of all, with a column under each heading that folds what is too wide."""
    # One space of padding and one for the divider: GAP.
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    for heading in headings:
        table.add_column(Text(heading), overflow="fold")
    return table


def text_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """Return a table of texts, in which what cannot be shown is escaped; those with a style stay as they are."""
    table = empty_table(*headings)
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(visible(str(cell))) for cell in row))
    return table


def wrap_text(text: str, width: int, indent: str = "", most: int = 0) -> list[str]:
    """Return the lines of a text, broken between words only.

    Parameters
    ----------
    text : str
        A blank that does not break, U+00A0, holds together what is beside it, and is an ordinary one in the end.
    width : int
        Of a line, but for a word that is longer by itself.
    indent : str
        Of all lines but the first.
    most : int
        Number of lines; an ellipsis stands for the middle, so that the last clause, often a hint, is kept. 0 for all.
    """
    wrapper = TextWrapper(width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    lines = wrapper.wrap(text)
    if most and len(lines) > most:
        lines = _leave_out(lines, text, width, indent, most)
    return [line.replace(TOGETHER, " ") for line in lines]


def _leave_out(lines: list[str], text: str, width: int, indent: str, most: int) -> list[str]:
    """Return the first lines and the last clause; the first lines alone where the clause would take all of them."""
    *_, clause = text.rpartition("; ")
    wrapper = TextWrapper(
        width, initial_indent=indent, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    last = wrapper.wrap(f"{MORE}{TOGETHER}{clause}") if clause != text else []
    if last and len(last) < most:
        return [*lines[: most - len(last)], *last]
    return [*lines[: most - 1], _shorten_line(lines[most - 1], width)]


def _shorten_line(line: str, width: int) -> str:
    words = line.split(" ")
    while len(words) > 1 and len(" ".join(words)) + 2 > width:
        words.pop()
    return f"{' '.join(words)} {MORE}"


class _Output(Console):
    """A console that ends quietly where nobody reads on."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        silence(self.file)


def output(*, unbroken: bool = False) -> Console:
    """Return the console on stdout: plain text where it is no terminal or ``NO_COLOR`` is set.

    Parameters
    ----------
    unbroken : bool
        Whether a table may be wider than 80 columns where it is no terminal and ``COLUMNS`` is not set.
    """
    console = _Output(highlight=False, markup=False, emoji=False)
    if unbroken and not console.is_terminal and not os.environ.get("COLUMNS", "").isdecimal():
        console.width = UNBROKEN
    return console


def errors() -> Console:
    """Return the console on stderr."""
    file = None if sys.stderr is None else unbounded(sys.stderr)
    return _Output(file=file, stderr=True, highlight=False, markup=False, emoji=False)


def silence(stream: IO[str]) -> None:
    """Let whatever is still written to a stream vanish, at the end of the process too."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def escape(text: str) -> str:
    """Return a text that stays in its line and in its cell, and is neither HTML, nor code, nor a link or image."""
    safe = visible(text).replace("&", "&amp;").replace("<", "&lt;").replace("`", "&#96;")
    return safe.replace("](", "]&#40;").replace("|", "\\|")
