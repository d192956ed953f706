"""Which names a module imports, read from its source."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

# Where statements hold others.
BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
WORD, CONTINUED = re.compile(rb"\bimport\b"), b"\\\n"
# An import that begins a line, with what it has in parentheses, whatever lines that is on.
STATEMENT = re.compile(rb"^[ \t]*((?:import|from[ \t]+\S+[ \t]+import)\b(?:[^(\n]*\([^)]*\))?[^\n]*)", re.MULTILINE)


@cache
def find_imports(module: str, file: Path) -> tuple[str, ...]:
    """Return the dotted names a module imports, those of attributes too, which name no module.

    Parameters
    ----------
    module : str
    file : Path
        That it is in; nothing is imported where it is no Python.
    """
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    tree = _parse(file.read_bytes())
    return tuple(_names(tree, package)) if tree is not None else ()


def _parse(source: bytes) -> ast.AST | None:
    """Return a tree with all imports of a source; None where it cannot be read."""
    # Parsing takes ten times as long as all else, and most of a source is no import.
    for text in (_statements_alone(source), source):
        try:
            return ast.parse(text)
        except (SyntaxError, ValueError):
            continue
    return None


def _statements_alone(source: bytes) -> bytes:
    """Return the imports of a source where each begins a line of its own, and else all of it."""
    found = STATEMENT.findall(source)
    return source if len(found) < len(WORD.findall(source)) or CONTINUED in source else b"\n".join(found)


def _names(tree: ast.AST, package: str) -> Iterator[str]:
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".") if node.level else []
            stem = [*parts[: len(parts) - node.level + 1], *([node.module] if node.module else [])]
            yield ".".join(stem)
            yield from (".".join([*stem, alias.name]) for alias in node.names)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements of a module, those within others, too; no import stands in an expression."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        inner = [child for part in BLOCKS for child in getattr(node, part, ())]
        yield from inner
        waiting += inner
