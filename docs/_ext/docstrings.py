"""Docstrings are written for ``help``: formulas in them are plain text, which pages typeset."""

import re
from collections.abc import Iterator
from typing import Any

from formulas import CODE, display, is_formula, typeset
from sphinx.application import Sphinx

UNDERLINE = re.compile(r"-{3,}$")


def setup(app: Sphinx) -> dict[str, bool]:
    """Rewrite docstrings before numpydoc reads them."""
    app.connect("autodoc-process-docstring", _rewrite, priority=100)
    return {"parallel_read_safe": True}


def _rewrite(_app: Sphinx, _what: str, _name: str, _thing: object, _options: Any, lines: list[str]) -> None:
    lines[:] = list(plain(lines))


def plain(lines: list[str]) -> Iterator[str]:
    """Escape markup in prose; typeset indented blocks above the first section, or leave them literal."""
    in_section, before = False, ""
    for indented, block in _blocks(lines):
        # What stands indented right below a line is the definition of a term.
        defines, before = bool(before.strip()), block[-1] if block else ""
        in_section |= any(UNDERLINE.match(line.strip()) for line in block)
        written = [line for line in block if line.strip()]
        if in_section:
            yield from (escaped(line) if line.startswith(" ") else untyped(line) for line in block)
        elif not indented or defines:
            yield from (escaped(re.sub("::$", ":" * (line != "::"), line)) for line in block)
        elif all(map(is_formula, written)):
            yield from ("", ".. math::", "", f"    {display(written)}", "")
        else:
            yield from ("", "::", "", *block, "")


def _blocks(lines: list[str]) -> Iterator[tuple[bool, list[str]]]:
    """Yield runs of lines that are indented, or not; an empty line is of the run before it."""
    indented, block = False, list[str]()
    for line in lines:
        if line.strip() and line.startswith("    ") != indented:
            yield indented, block
            indented, block = not indented, []
        block.append(line)
    yield indented, block


def escaped(line: str) -> str:
    """Typeset the formulas of a line, and escape what is no code."""
    return typeset(line, lambda formula: f":math:`{formula}`", _plain)


def untyped(line: str) -> str:
    """Escape what is no code of a line that names a section, or a parameter and its type."""
    if UNDERLINE.match(line.strip()):
        return line
    return "".join(part if CODE.fullmatch(part) else _plain(part) for part in CODE.split(line))


def _plain(text: str) -> str:
    return re.sub(r"([*|]|_(?=\W|$))", r"\\\1", text)
