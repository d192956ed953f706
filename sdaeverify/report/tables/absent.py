"""Cells that do not apply, in the format of ``not_applicable.csv``: one row for each scheme and reason.

Of S schemes, P problems and M measures most of the S P M cells do not apply, and most of the reasons are about the
form of the problem alone. A row holds all problems and all measures of a scheme that have one reason, so that their
number is about S times the number of forms.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from ...contracts.labels import split_list

SEPARATOR = ", "
KEY = ("scheme", "problem", "measure", "quantity")


class AbsentGroup(NamedTuple):
    """Cells of a scheme that do not apply for one reason: all pairs of the problems and the measures.

    Attributes
    ----------
    scheme, quantity, reason : str
    problems, measures : tuple of str
    """

    scheme: str
    problems: tuple[str, ...]
    measures: tuple[str, ...]
    quantity: str
    reason: str

    @property
    def row(self) -> dict[str, str]:
        """Row of the file, with lists as `split_list` reads them."""
        lists = {name: SEPARATOR.join(getattr(self, name)) for name in ("problems", "measures")}
        return {**self._asdict(), **lists}


def group_absent(rows: Iterable[Mapping[str, Any]]) -> list[AbsentGroup]:
    """Group cells by scheme, quantity and reason, in the order of the first cell of each group.

    Parameters
    ----------
    rows : iterable of mapping
        Rows with ``scheme``, ``problem``, ``measure``, ``quantity`` and ``reason``.
    """
    problems: dict[tuple[str, ...], dict[str, None]] = {}
    for row in rows:
        key = (row["scheme"], row["quantity"], row["reason"], row["measure"])
        problems.setdefault(key, {})[row["problem"]] = None
    measures: dict[tuple[Any, ...], list[str]] = {}
    for (scheme, quantity, reason, measure), found in problems.items():
        measures.setdefault((scheme, tuple(found), quantity, reason), []).append(measure)
    return [AbsentGroup(key[0], key[1], tuple(found), *key[2:]) for key, found in measures.items()]


def ungroup_absent(rows: Iterable[Mapping[str, str]]) -> list[dict[str, str]]:
    """Return a row for each cell of the rows of ``not_applicable.csv``, see `in_order`.

    Parameters
    ----------
    rows : iterable of mapping
        Rows as `AbsentGroup.row` returns them.
    """
    lists: dict[str, list[str]] = {}
    cells = []
    for row in rows:
        problems, measures = (lists.setdefault(row[name], split_list(row[name])) for name in ("problems", "measures"))
        rest = {name: row[name] for name in ("quantity", "reason")}
        cells += [
            {"scheme": row["scheme"], "problem": problem, "measure": measure, **rest}
            for problem in problems
            for measure in measures
        ]
    return in_order(cells)


def in_order(cells: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sort cells by scheme, problem, measure and quantity."""
    return sorted(cells, key=lambda cell: [cell[name] for name in KEY])
