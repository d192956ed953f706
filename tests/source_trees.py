"""The sources of the repository as syntax trees, each parsed and walked once in a process, whatever asks for it."""

import ast
from collections import defaultdict
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@cache
def sources(*folders: Path) -> list[Path]:
    """Return the Python files below some folders."""
    return sorted(path for folder in folders for path in folder.rglob("*.py"))


@cache
def text_of(path: Path) -> str:
    """Return the text of a file."""
    return path.read_text(encoding="utf-8")


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(text_of(path))


def nodes(tree: ast.AST, *kinds: type[ast.AST]) -> list[ast.AST]:
    """Return the nodes of a tree, itself first: those of some classes, class by class, or all."""
    by_kind = _by_kind(tree)
    return [node for kind in kinds or by_kind for node in by_kind.get(kind, ())]


@cache
def _by_kind(tree: ast.AST) -> dict[type, list[ast.AST]]:
    by_kind = defaultdict(list)
    for node in ast.walk(tree):
        by_kind[type(node)].append(node)
    return by_kind
