"""Plain text and tables of all commands, and their consoles."""

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
# Width beyond that of any table, so that a line piped into another program is not broken.
UNBROKEN = 10_000


def visible(text: str) -> str:
    """Replace unprintable characters, such as control characters, by escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def empty_table(*headings: str) -> Table:
    """Return a table in the common style, whose columns wrap long cells."""
    # One space of padding, and one for the divider.
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    for heading in headings:
        table.add_column(Text(heading), overflow="fold")
    return table


def text_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """Return a table of texts with unprintable characters escaped, except in styled texts."""
    table = empty_table(*headings)
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(visible(str(cell))) for cell in row))
    return table


def fits_width(console: Console, table: Table) -> bool:
    """Return whether no cell of a table has to be wrapped on a console."""
    return console.measure(table, options=console.options.update(width=UNBROKEN)).maximum <= console.width


def wrap_text(text: str, width: int, indent: str = "", most: int = 0) -> list[str]:
    """Wrap a text between words.

    Parameters
    ----------
    text : str
        Text to wrap. A non-breaking space, U+00A0, is not a break point and becomes an ordinary space.
    width : int
        Width of a line; a longer word is not broken.
    indent : str
        Indent of all lines except the first.
    most : int
        Largest number of lines, 0 for no limit. The middle is replaced by an ellipsis to keep the last clause, often
        a hint.
    """
    wrapper = TextWrapper(width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    lines = wrapper.wrap(text)
    if most and len(lines) > most:
        lines = _leave_out(lines, text, width, indent, most)
    return [line.replace(TOGETHER, " ") for line in lines]


def _leave_out(lines: list[str], text: str, width: int, indent: str, most: int) -> list[str]:
    """Return the first lines and the last clause, or only the first lines if the clause is too long."""
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
    """Console that ends quietly if the reader closes the pipe."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        silence(self.file)


def output(*, unbroken: bool = False) -> Console:
    """Return the console on stdout: plain text if it is not a terminal or ``NO_COLOR`` is set.

    Parameters
    ----------
    unbroken : bool
        Whether a table may exceed 80 columns if stdout is not a terminal and ``COLUMNS`` is not set.
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
    """Redirect a stream to the null device, so that later writes, even at exit, raise no error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def escape(text: str) -> str:
    """Escape a text for a Markdown cell, so that it stays on its line and is not HTML, code, link or image."""
    safe = visible(text).replace("&", "&amp;").replace("<", "&lt;").replace("`", "&#96;")
    return safe.replace("](", "]&#40;").replace("|", "\\|")
