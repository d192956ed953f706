"""The cells of a table: what their column means, and how they are read, be they values or the texts of a file."""

from collections.abc import Callable, Iterable, Mapping
from math import nan
from typing import NamedTuple, TypeVar

TEXT, NUMBER, WHOLE, TRUTH = "text", "number", "whole number", "truth value"

# How pandas writes a cell that holds nothing, of a floating and of a nullable type.
EMPTY = frozenset({"nan", "<NA>"})
Row = Mapping[str, object]
Key = TypeVar("Key")
Item = TypeVar("Item")


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Return items by their key, in the order of the first of each."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


class Column(NamedTuple):
    """A column.

    Attributes
    ----------
    name, meaning : str
    kind : str
        Text, number, whole number or truth value; an empty cell says that there is none.
    unit : str
        Empty for what has none.
    label : str
        Before its value where all that is known of a quantity is told; empty for what has words of its own there.
    on_page : bool
        Whether the page of a run has it.
    """

    name: str
    meaning: str
    kind: str = TEXT
    unit: str = ""
    label: str = ""
    on_page: bool = True


def number_column(name: str, meaning: str, unit: str = "") -> Column:
    """Return a column of numbers.

    Parameters
    ----------
    name, meaning, unit : str
        As in `Column`.
    """
    return Column(name, meaning, NUMBER, unit)


def names(columns: Iterable[Column]) -> tuple[str, ...]:
    """Return the names of columns."""
    return tuple(column.name for column in columns)


def text(row: Row, name: str) -> str:
    """Return a text of a row; empty where it has none."""
    found = row.get(name)
    told = "" if found is None else str(found)
    return "" if told in EMPTY else told


def number(row: Row, name: str) -> float:
    """Return a number of a row; NaN where it has none."""
    return parse(text(row, name))


def parse(told: str) -> float:
    """Return a number; NaN where a text is none."""
    try:
        return float(told or nan)
    except ValueError:
        return nan
