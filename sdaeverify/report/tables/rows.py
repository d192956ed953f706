"""Results as tables: a row for each quantity, each quantity and step size, and each inapplicable cell."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import nan
from types import NoneType
from typing import Any, NamedTuple

import pandas as pd

from ...arrays import Array
from ...contracts.finding import Finding, Verdict
from ...contracts.settings import Settings
from ...simulate.tracks import COST, COUNTED
from ...study import CellResult
from .. import folders
from ..cells import WHOLE, Column, names
from ..sentences import SYMBOLS
from ..verdict_row import VERDICTS, VerdictRow
from .absent import in_order
from .columns import (
    CLASS_COLUMNS,
    CLASS_DETAILS,
    CLASSES,
    COLUMNS,
    DETAILS,
    LEVELS,
    MEAN,
    NOT_APPLICABLE,
    details_file,
    dictionary,
)

Record = dict[str, object]


class Rows(NamedTuple):
    """Rows of a run except its levels.

    Attributes
    ----------
    verdicts : list of VerdictRow
        Claimed or measured quantities on problems.
    absent : list of dict
        Cells that do not apply.
    details : dict of str to list of dict
        Further columns of the verdicts, by measure; ``classes`` for verdicts on classes.
    classes : list of VerdictRow
        Verdicts on classes of equations.
    """

    verdicts: list[VerdictRow]
    absent: list[Record]
    details: dict[str, list[Record]]
    classes: list[VerdictRow]

    @property
    def every(self) -> list[VerdictRow]:
        """All rows of ``verdicts.csv``, those on problems first."""
        return [*self.verdicts, *self.classes]

    @property
    def of_classes(self) -> list[Record] | None:
        """Rows of classes with their details; None if classes were not part of the run."""
        if CLASSES not in self.details:
            return None
        return folders.joined_classes((row.cells for row in self.classes), self.details[CLASSES])


def rows_of(results: Iterable[CellResult], *, with_classes: bool = False) -> Rows:
    """Return one row for each finding, by the table in which it stands: verdicts, classes, details, not applicable.

    Parameters
    ----------
    results : iterable of CellResult
    with_classes : bool
        Whether there is a table of classes even if no finding is about a class of equations.
    """
    rows = Rows([], [], {CLASSES: []} if with_classes else {}, [])
    for result in results:
        for finding in result.findings:
            named = folders.key_in(result.cell, finding.quantity)._asdict()
            if finding.verdict is Verdict.NOT_APPLICABLE:
                rows.absent.append({**named, "reason": str(finding.reason)})
                continue
            if result.cell.class_name is not None:
                rows.classes.append(VerdictRow.from_finding(finding, result))
                rows.details.setdefault(CLASSES, []).append({**named, **finding.details})
                continue
            rows.verdicts.append(VerdictRow.from_finding(finding, result))
            rows.details.setdefault(result.cell.measure.name, []).append({**named, **_list_details(result, finding)})
    return rows._replace(absent=in_order(rows.absent))


def tables_of(rows: Rows, results: Sequence[CellResult], settings: Settings) -> dict[str, pd.DataFrame]:
    """Return the tables of a run by file name, including the dictionary of columns.

    Parameters
    ----------
    rows : Rows
        Rows of the results.
    results : sequence of CellResult
    settings : Settings
    """
    measures = dict.fromkeys(result.cell.measure for result in results)
    known = {CLASSES: CLASS_DETAILS}
    levels = [row for result in results for row in _level_rows(result, settings)]
    return {
        folders.VERDICTS: as_verdicts(table_of([row.cells for row in rows.every], VERDICTS)),
        folders.NOT_APPLICABLE: table_of(rows.absent, NOT_APPLICABLE),
        **{details_file(name): table_of(details, known.get(name, DETAILS)) for name, details in rows.details.items()},
        folders.LEVELS: table_of(levels, LEVELS),
        COLUMNS: table_of(list(dictionary(measures))),
    }


def as_verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with the verdict as an ordered category, worst first."""
    return table.astype({"verdict": pd.CategoricalDtype([*SYMBOLS], ordered=True)})


def classes_table(rows: Iterable[Mapping[str, object]]) -> pd.DataFrame:
    """Return the table of classes, with the claimed order in place of the claim in words."""
    named = ({**row, "claim": row["claimed_order"]} for row in rows)
    return table_of([{name: row.get(name) for name in names(CLASS_COLUMNS)} for row in named], CLASS_COLUMNS)


def records(table: pd.DataFrame) -> list[dict[str, object]]:
    """Return the rows of a table as mappings."""
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


def table_of(rows: Sequence[Mapping[str, object]], columns: Sequence[Column] = ()) -> pd.DataFrame:
    """Convert rows to a table, with the given columns first, followed by all other keys of the rows."""
    known = names(columns)
    every = dict.fromkeys(chain(known, *rows))
    whole = {column.name for column in columns if column.kind == WHOLE} | (every.keys() - {*known})
    told: dict[str, list[Any]] = {name: [None] * len(rows) for name in every}
    for place, row in enumerate(rows):
        for name, value in row.items():
            told[name][place] = value
    return pd.DataFrame({name: _column(values, whole=name in whole) for name, values in told.items()})


def _column(values: list[Any], *, whole: bool) -> "pd.Series[Any]":
    """Return a column; whole numbers and truth values have a nullable type even if no cell is empty."""
    kinds = {*map(type, values)} - {NoneType}
    # Counts in evidence of other sources may exceed 64 bits.
    if whole and kinds == {int} and all(value is None or abs(value) < 2**63 for value in values):
        return pd.Series(values, dtype="Int64")
    if kinds == {bool}:
        return pd.Series(values, dtype="boolean")
    return pd.Series(values) if kinds else pd.Series(values, dtype=float)


def _list_details(result: CellResult, finding: Finding) -> Record:
    return {
        "method": str(finding.method or ""),
        "claim_source": finding.claim.source if finding.claim else "",
        "seconds": round(result.seconds, 3),
        "step_seconds": float(f"{result.step_seconds:.3g}"),
        **{column_name(name): value for name, value in finding.details.items() if name not in IN_VERDICTS},
    }


IN_VERDICTS = {"local_order"}


def _level_rows(result: CellResult, settings: Settings) -> Iterator[dict[str, Any]]:
    # The quantities of a cell share the data on the steps of a level.
    levels = {row.level for row in result.levels if row.level is not None}
    steps = {level: _of_level(result, settings, level) for level in levels}
    for row in result.levels:
        yield {
            **folders.key_in(result.cell, row.quantity)._asdict(),
            "h": row.h,
            "estimate": row.estimate,
            "std_error": row.std_error,
            **({} if row.level is None else steps[row.level]),
            **{column_name(name): value for name, value in row.details.items()},
        }


def _of_level(result: CellResult, settings: Settings, level: int) -> Record:
    health, made = result.health.sums, result.health.sums["steps"][level]
    # Paths may have been simulated at further levels than those of the run.
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
    """Return the mean of each cost over the steps that report it; NaN if none does."""
    costs = [name.removeprefix(COST) for name in health if name.startswith(COST)]
    counts = {name: health[f"{COUNTED}{name}"][level] for name in costs}
    means = {n: float(health[f"{COST}{n}"][level] / counts[n]) if counts[n] else nan for n in costs}
    return {column_name(f"{MEAN}{name}"): mean for name, mean in means.items()}


def column_name(name: str) -> str:
    """Convert a name to an identifier, so that the column is an attribute of a table row."""
    return re.sub(r"\W+|^(?=\d)", "_", name)
