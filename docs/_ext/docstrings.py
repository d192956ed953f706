"""Docstrings are written for ``help``: formulas in them are plain text, and reStructuredText must read no markup."""

import re
from collections.abc import Iterator
from typing import Any

from sphinx.application import Sphinx

CODE = re.compile(r"(``.+?``|`.+?`)")
UNDERLINE = re.compile(r"-{3,}$")


def setup(app: Sphinx) -> dict[str, bool]:
    """Rewrite docstrings before numpydoc reads them."""
    app.connect("autodoc-process-docstring", _rewrite, priority=100)
    return {"parallel_read_safe": True}


def _rewrite(_app: Sphinx, _what: str, _name: str, _thing: object, _options: Any, lines: list[str]) -> None:
    lines[:] = list(plain(lines))


def plain(lines: list[str]) -> Iterator[str]:
    """Escape markup in prose; indented blocks above the first section are formulas, and become literal."""
    in_section, in_formula = False, False
    for number, line in enumerate(lines):
        after = lines[number + 1] if number + 1 < len(lines) else ""
        in_section |= bool(UNDERLINE.match(after.strip())) and bool(line.strip())
        indented = line.startswith("    ")
        if indented and not in_section and not in_formula and not (number and lines[number - 1].strip()):
            in_formula = True
            if not _announced(lines[:number]):
                yield from ("::", "")
        in_formula &= indented or not line.strip()
        yield line if in_formula else escaped(line)


def _announced(above: list[str]) -> bool:
    told = [line for line in above if line.strip()]
    return bool(told) and told[-1].rstrip().endswith("::")


def escaped(line: str) -> str:
    """Escape what is no code."""
    if UNDERLINE.match(line.strip()):
        return line
    parts = CODE.split(line)
    return "".join(part if CODE.fullmatch(part) else re.sub(r"([*|]|_(?=\W|$))", r"\\\1", part) for part in parts)
