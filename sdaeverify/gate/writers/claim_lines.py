"""Where in the source of a scheme a claim is written."""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from ...contracts.scheme import Claim, Scheme

LITERAL = ("measure", "value", "source", "quantities", "margin")


class Place(NamedTuple):
    """A line of a file."""

    file: Path
    line: int


def claim_place(scheme: Scheme, claim: Claim | None) -> Place | None:
    """Return the line of a claim, or that of its scheme's class where it is not written in the same file.

    Parameters
    ----------
    scheme : Scheme
    claim : Claim or None
        None for the class itself.

    Returns
    -------
    Place or None
        None where there is no source.
    """
    kind = type(scheme)
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    tree = _parsed(Path(file)) if file else None
    if file is None or tree is None:
        return None
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef) and node.name == kind.__name__]
    if claim is not None:
        for part in (*classes, tree):
            if (line := next((call.lineno for call in _calls(part) if _agrees(call, claim)), None)) is not None:
                return Place(Path(file), line)
    return Place(Path(file), classes[0].lineno if classes else 1)


@cache
def _parsed(file: Path) -> ast.Module | None:
    try:
        return ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return None


def _calls(node: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls of ``Claim``, as a name or as an attribute of a module."""
    for call in ast.walk(node):
        if isinstance(call, ast.Call):
            name = getattr(call.func, "id", None) or getattr(call.func, "attr", None)
            if name == Claim.__name__:
                yield call


def _agrees(call: ast.Call, claim: Claim) -> bool:
    given = {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg in LITERAL}
    known = {name: node.value for name, node in given.items() if isinstance(node, ast.Constant)}
    return known.get("measure") == claim.measure and all(
        getattr(claim, str(name)) == value for name, value in known.items()
    )
