"""What the formulas of a problem are made of, so that a step compiled for one object serves the next one like it.

A problem is built anew for each block of paths. Two of them have the same formulas if their functions have the same
code, the same defaults and the same values in their closures; what cannot be compared by value counts by identity,
and is then compiled again.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, partial
from types import CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from sdaeverify import Problem

PLAIN = (type(None), bool, int, float, complex, str, bytes, slice, np.generic)
# What no step depends on.
COMMON = frozenset(field.name for field in fields(Problem)) - {"noise_dim", "traits"}


@dataclass(frozen=True, eq=False)
class Formulas:
    """A problem as a key: equal to those of the same form with the same formulas.

    Attributes
    ----------
    problem : Problem
        It is held as long as the key: things that count by identity stay what they are.
    """

    problem: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Formulas) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @cached_property
    def key(self) -> Hashable:
        """The values that the formulas are made of."""
        own = (field.name for field in fields(self.problem) if field.name not in COMMON)
        values = {name: getattr(self.problem, name) for name in own}
        return type(self.problem), content(values)


def content(value: Any, above: tuple[int, ...] = ()) -> Hashable:
    """Return a value that is equal for things made of the same code and the same numbers.

    Parameters
    ----------
    value : object
    above : tuple of int
        Identities of what contains it: a function may be in its own closure.
    """
    if isinstance(value, PLAIN):
        # 1, 1.0 and True are equal, as are 0.0 and -0.0; formulas tell them apart.
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
    """Return what a thing is made of; nothing for one that counts by identity."""
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
