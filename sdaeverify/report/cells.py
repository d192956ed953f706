"""Columns of tables with their meanings, and parsing of cells that are values or texts of a file."""

from collections.abc import Callable, Iterable, Mapping
from math import nan
from typing import NamedTuple, TypeVar

TEXT, NUMBER, WHOLE, TRUTH = "text", "number", "whole number", "truth value"

# Text of an empty cell in pandas, for a floating and for a nullable type.
EMPTY = frozenset({"nan", "<NA>"})
Row = Mapping[str, object]
Key = TypeVar("Key")
Item = TypeVar("Item")


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Group items by key, in the order of the first item of each group."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


class Column(NamedTuple):
    """Description of a table column.

    Attributes
    ----------
    name, meaning : str
    kind : str
        Text, number, whole number or truth value; an empty cell means a missing value.
    unit : str
        Empty for a dimensionless column.
    label : str
        Label of the value in the full report of a quantity; empty if the report has a special phrase for it.
    on_page : bool
        Whether the page of a run shows the column.
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
        See `Column`.
    """
    return Column(name, meaning, NUMBER, unit)


def names(columns: Iterable[Column]) -> tuple[str, ...]:
    """Return the names of columns."""
    return tuple(column.name for column in columns)


def text(row: Row, name: str) -> str:
    """Return the text of a cell; empty if it is missing."""
    found = row.get(name)
    told = "" if found is None else str(found)
    return "" if told in EMPTY else told


def number(row: Row, name: str) -> float:
    """Return the number of a cell; NaN if it is missing or not a number."""
    return parse(text(row, name))


def parse(told: str) -> float:
    """Convert a text to a number; NaN if it is not one."""
    try:
        return float(told or nan)
    except ValueError:
        return nan
