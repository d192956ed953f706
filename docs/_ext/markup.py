"""Pieces of Markdown."""

from collections.abc import Iterable, Sequence


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(cell(text) for text in line) + " |" for line in lines) + "\n"


def cell(text: str) -> str:
    """Return text of a cell on one line."""
    return " ".join(text.split()).replace("|", "\\|")


def prose(text: str) -> str:
    """Return plain text in which nothing is markup."""
    for mark in "\\*_`<>[]$#|":
        text = text.replace(mark, f"\\{mark}")
    return text


def verbatim(text: str, language: str = "text") -> str:
    """Return a block of text."""
    return f"```````{language}\n{text.rstrip()}\n```````\n"


def page(title: str, *blocks: str) -> str:
    """Return a page."""
    return "\n\n".join([f"# {title}", *(block for block in blocks if block)]) + "\n"


def toctree(names: Iterable[str], *, hidden: bool = True) -> str:
    """Return a table of contents."""
    options = [":hidden:"] if hidden else [":maxdepth: 1"]
    return "\n".join(["```{toctree}", *options, "", *names, "```"])
