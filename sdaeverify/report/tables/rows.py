"""Results as rows: one a quantity, one a quantity and step size, and one for what does not apply."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import nan
from types import NoneType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.finding import Finding, Verdict
from ...contracts.settings import Settings
from ...simulate.tracks import COST, COUNTED
from ...study import CellResult
from .. import folders
from ..cells import WHOLE, Column, names
from ..verdict_row import VERDICTS, VerdictRow
from .columns import DETAILS, LEVELS, MEAN, NOT_APPLICABLE, details_file

if TYPE_CHECKING:
    import pandas as pd

INTEGER, REAL = (int, np.integer), (float, np.floating)
Record = dict[str, object]


class Rows(NamedTuple):
    """The rows of a run but for its levels.

    Attributes
    ----------
    verdicts : list of VerdictRow
        What is claimed or measured.
    absent : list of dict
        What does not apply.
    details : dict of str to list of dict
        By measure, further columns of the verdicts.
    """

    verdicts: list[VerdictRow]
    absent: list[Record]
    details: dict[str, list[Record]]


def rows_of(results: Iterable[CellResult]) -> Rows:
    """Return the rows of results."""
    rows = Rows([], [], {})
    for result in results:
        for finding in result.findings:
            named = _names(result, finding.quantity)
            if finding.verdict is Verdict.NOT_APPLICABLE:
                rows.absent.append({**named, "reason": str(finding.reason)})
                continue
            rows.verdicts.append(VerdictRow.from_finding(finding, result))
            rows.details.setdefault(result.cell.measure.name, []).append({**named, **_list_details(result, finding)})
    return rows


class Table(NamedTuple):
    """Columns of equal length.

    Attributes
    ----------
    columns : dict of str to list
        None where a row has no such value.
    whole : frozenset of str
        Columns of whole numbers.
    """

    columns: dict[str, list[object]]
    whole: frozenset[str]

    @property
    def frame(self) -> "pd.DataFrame":
        """The table for pandas."""
        import pandas as pd  # noqa: PLC0415 - whoever asks for files alone need not wait for it

        told = {name: [nan if v is None else v for v in column] for name, column in self.columns.items()}
        whole = (name for name in self.whole if all(v is None or _is_whole(v) for v in self.columns[name]))
        # A column of whole numbers reads the same whether or not other rows leave it empty.
        return pd.DataFrame(told).astype(dict.fromkeys(whole, "Int64"))


def tables_of(rows: Rows) -> dict[str, Table]:
    """Return rows as tables, by the names of their files."""
    told = [row.cells for row in rows.verdicts]
    found = {folders.VERDICTS: (told, VERDICTS), folders.NOT_APPLICABLE: (rows.absent, NOT_APPLICABLE)}
    found |= {details_file(measure): (details, DETAILS) for measure, details in rows.details.items()}
    return {file: table_of(listed, columns) for file, (listed, columns) in found.items()}


def level_table(results: Iterable[CellResult], settings: Settings) -> Table:
    """Return one row for each quantity of each cell at each step size.

    Parameters
    ----------
    results : iterable of CellResult
    settings : Settings

    Returns
    -------
    Table
        The columns of all measures first, then those of some.
    """
    return table_of([row for result in results for row in _level_rows(result, settings)], LEVELS)


def table_of(rows: Sequence[Mapping[str, object]], columns: Sequence[Column] = ()) -> Table:
    """Return rows as a table: the columns that are known first, then whatever else the rows have."""
    known = names(columns)
    every = dict.fromkeys(chain(known, *rows))
    whole = {column.name for column in columns if column.kind == WHOLE} | (every.keys() - {*known})
    told: dict[str, list[object]] = {name: [None] * len(rows) for name in every}
    for place, row in enumerate(rows):
        for name, value in row.items():
            told[name][place] = value
    return Table({name: _column(values, whole=name in whole) for name, values in told.items()}, frozenset(whole))


def _column(values: list[Any], *, whole: bool) -> list[object]:
    """Return numbers of one kind: whole ones become floats where others are not whole, or where some are missing."""
    kinds = {*map(type, values)}
    integers = {kind for kind in kinds if issubclass(kind, INTEGER)}
    others = kinds - integers
    if not integers or not others or (whole and integers == {int} and others == {NoneType}):
        return values
    if bool in kinds or not all(issubclass(kind, (*REAL, NoneType)) for kind in others):
        return values
    return [None if value is None else float(value) for value in values]


def _is_whole(value: object) -> bool:
    # Evidence from elsewhere may count to any number.
    return type(value) is int and abs(value) < 2**63


def _names(result: CellResult, quantity: str) -> Record:
    cell = result.cell
    return {
        "scheme": cell.scheme.label,
        "problem": cell.spec.label,
        "measure": cell.measure.name,
        "quantity": quantity,
    }


def _list_details(result: CellResult, finding: Finding) -> Record:
    return {
        "method": finding.method,
        "claim_source": finding.claim.source if finding.claim else "",
        "seconds": round(result.seconds, 3),
        "step_seconds": float(f"{result.step_seconds:.3g}"),
        **{name: value for name, value in finding.details.items() if name not in IN_VERDICTS},
    }


IN_VERDICTS = {"local_order"}


def _level_rows(result: CellResult, settings: Settings) -> Iterator[dict[str, Any]]:
    # Its quantities share what is told of the steps of a level.
    levels = {row.level for row in result.levels if row.level is not None}
    steps = {level: _of_level(result, settings, level) for level in levels}
    for row in result.levels:
        yield {
            **_names(result, row.quantity),
            "h": row.h,
            "estimate": row.estimate,
            "std_error": row.std_error,
            **({} if row.level is None else steps[row.level]),
            **row.details,
        }


def _of_level(result: CellResult, settings: Settings, level: int) -> Record:
    health, made = result.health.sums, result.health.sums["steps"][level]
    # Paths may have gone on beyond the levels of the run.
    steps = settings.coarsest * 2**level
    return {
        "h": result.horizon / steps,
        "paths": result.paths,
        "failed_paths": int(health["failed"][level]),
        "truncated_share": float(health["truncated"][level] / made),
        "steps": steps,
        "lost_paths": int(health["lost"][level]),
        **_means(health, level),
    }


def _means(health: Mapping[str, Array], level: int) -> dict[str, float]:
    """Return each cost's mean over the steps that have it; NaN if none has."""
    costs = [name.removeprefix(COST) for name in health if name.startswith(COST)]
    counts = {name: health[f"{COUNTED}{name}"][level] for name in costs}
    return {f"{MEAN}{n}": float(health[f"{COST}{n}"][level] / counts[n]) if counts[n] else nan for n in costs}
