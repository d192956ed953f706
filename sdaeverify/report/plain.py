"""Text and tables as every command shows them, whatever they are about."""

from rich import box
from rich.table import Table
from rich.text import Text


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
