"""The tables of a folder as tables of a result, with texts converted back to values."""

from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import pandas as pd

from .. import folders
from ..cells import NUMBER, TEXT, WHOLE, Column, parse
from ..files import FORMULA
from ..verdict_row import VERDICTS, VerdictRow
from .columns import CLASS_DETAILS, CLASSES, COLUMNS, DETAILS, LEVELS, NOT_APPLICABLE, details_file
from .rows import Record, Rows, as_verdicts, table_of

TRUTHS = {"True": True, "False": False}


def read_result(folder: Path) -> tuple[Rows, dict[str, pd.DataFrame], dict[str, Any]]:
    """Return the rows and tables of the run in a folder, and the contents of ``run.json``.

    Raises
    ------
    UsageError
        If the folder holds no run, or one that was not written by this program.
    """
    found = folders.read_verdicts(folder)
    verdicts, classes = ([VerdictRow.from_row(row) for row in some] for some in (found.verdicts, found.classes))
    rows = Rows(verdicts, _typed(found.absent, NOT_APPLICABLE), {}, classes)
    tables = {
        folders.VERDICTS: as_verdicts(table_of([row.cells for row in rows.every], VERDICTS)),
        folders.NOT_APPLICABLE: table_of(rows.absent, NOT_APPLICABLE),
    }
    for file in sorted((folder / folders.DETAILS).glob("*.csv")):
        columns = CLASS_DETAILS if file.stem == CLASSES else DETAILS
        rows.details[file.stem] = _typed(folders.read_table(file), columns)
        tables[details_file(file.stem)] = table_of(rows.details[file.stem], columns)
    tables[folders.LEVELS] = table_of(_typed(folders.read_table(folder / folders.LEVELS), LEVELS), LEVELS)
    tables[COLUMNS] = table_of(folders.read_table(folder / COLUMNS, names=()))
    return rows, tables, found.run


def _typed(rows: Iterable[Mapping[str, str]], columns: Iterable[Column]) -> list[Record]:
    kinds = {column.name: column.kind for column in columns}
    return [{name: _value(told, kinds.get(name, "")) for name, told in row.items()} for row in rows]


def _value(told: str, kind: str) -> Any:
    """Convert the text of a cell; the type of an unknown column is guessed from the text."""
    if kind == TEXT:
        return told[1:] if told.startswith("'") and told[1:].lstrip().startswith(FORMULA) else told
    if not told:
        return None
    if kind == NUMBER:
        return parse(told)
    if kind == WHOLE or told.removeprefix("-").isdecimal():
        return _whole(told)
    return TRUTHS[told] if told in TRUTHS else _number_or_text(told)


def _whole(told: str) -> int | None:
    number = parse(told)
    return int(number) if isfinite(number) else None


def _number_or_text(told: str) -> float | str:
    number = parse(told)
    return told if number != number and told != "nan" else number  # noqa: PLR0124 - NaN
