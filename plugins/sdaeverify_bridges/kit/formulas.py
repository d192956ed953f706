"""Comparison of the formulas of problems by value, so that a compiled step can be reused for an equal problem.

A problem is built anew for each block of paths. Two problems have the same formulas if their functions have the same
code, defaults and closure values. Objects that cannot be compared by value are compared by identity, which causes
another compilation.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, partial
from types import CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from sdaeverify import Problem

PLAIN = (type(None), bool, int, float, complex, str, bytes, slice, np.generic)
# Fields of a problem on which no step depends.
COMMON = frozenset(field.name for field in fields(Problem)) - {"noise_dim", "traits"}


@dataclass(frozen=True, eq=False)
class Formulas:
    """A problem as a hashable key, equal to problems of the same form with the same formulas.

    Attributes
    ----------
    problem : Problem
        The problem, kept alive so that identities of its objects remain valid.
    """

    problem: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Formulas) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @cached_property
    def key(self) -> Hashable:
        """Values that determine the formulas."""
        own = (field.name for field in fields(self.problem) if field.name not in COMMON)
        values = {name: getattr(self.problem, name) for name in own}
        return type(self.problem), content(values)


def content(value: Any, above: tuple[int, ...] = ()) -> Hashable:
    """Return a hashable value that is equal for objects with the same code and numbers.

    Parameters
    ----------
    value : object
    above : tuple of int
        Identities of enclosing objects, because a function may be in its own closure.
    """
    if isinstance(value, PLAIN):
        # 1, 1.0 and True compare equal, as do 0.0 and -0.0, but formulas distinguish them.
        return type(value), repr(value)
    if isinstance(value, CodeType):
        return value
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if id(value) in above:
        return "above", len(above) - above.index(id(value))
    parts = _parts(value)
    return type(value), (tuple(content(part, (*above, id(value))) for part in parts) if parts else id(value))


def _parts(value: Any) -> tuple[Any, ...]:
    """Return the parts of an object; empty for one compared by identity."""
    for kind, taken_apart in APART:
        if isinstance(value, kind):
            return taken_apart(value)
    is_record = is_dataclass(value) and not isinstance(value, type)
    return ("record", *(getattr(value, field.name) for field in fields(value))) if is_record else ()


def _function(value: FunctionType) -> tuple[Any, ...]:
    cells = [cell.cell_contents for cell in value.__closure__ or () if not _is_empty(cell)]
    return value.__code__, id(value.__globals__), value.__defaults__, value.__kwdefaults__, *cells


def _is_empty(cell: CellType) -> bool:
    try:
        cell.cell_contents  # noqa: B018
    except ValueError:
        return True
    return False


APART: tuple[tuple[Any, Callable[[Any], tuple[Any, ...]]], ...] = (
    (FunctionType, _function),
    (MethodType, lambda method: (method.__func__, method.__self__)),
    (partial, lambda bound: (bound.func, bound.args, bound.keywords)),
    (dict, lambda pairs: ("pairs", *(item for pair in pairs.items() for item in pair))),
    (tuple | list, lambda items: ("items", *items)),
    (frozenset | set, lambda items: ("members", *sorted(items, key=repr))),
)
