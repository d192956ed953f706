"""Tables in the folder of a run: written atomically and read as texts, without executing code."""

import csv
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..contracts.finding import Verdict
from ..contracts.labels import parse_label, text_of
from ..errors import UsageError
from ..study.every_equation import EVERY_EQUATION
from .files import PARQUET, read_rows, require_writable, write_json, write_table
from .tables.absent import AbsentGroup, group_absent, ungroup_absent

if TYPE_CHECKING:
    import pandas as pd

    from ..study import Cell

# Class of a label that names none.
GENERAL = "general"
# Version of the file format; version 1 had a single table for verdicts and for cells that do not apply.
SCHEMA = 3
# Advice of how to create a run.
MAKE = "sdaeverify matrix --out FOLDER makes one"
VERDICTS, NOT_APPLICABLE, LEVELS, RUN = "verdicts.csv", "not_applicable.csv", "levels.csv", "run.json"
DETAILS = "details"
CLASSES = f"{DETAILS}/classes.csv"
TextRow = Mapping[str, str]


class Key(NamedTuple):
    """Key of a row: labels of scheme and problem, names of measure and quantity."""

    scheme: str
    problem: str
    measure: str
    quantity: str

    def __str__(self) -> str:
        return f"{self.scheme} on {self.problem}, {self.measure} {self.quantity}".rstrip(", ")


NAMES = Key._fields


class SavedTables(NamedTuple):
    """Tables of a run, read from its folder.

    Attributes
    ----------
    folder : Path
    verdicts, absent : sequence of mapping of str to str
        Rows of claimed or measured quantities on problems, and rows of cells that do not apply.
    run : dict
        The contents of ``run.json``.
    levels, details : sequence of mapping of str to str
        Rows of levels and details; empty if they were not read.
    classes : sequence of mapping of str to str
        Rows of verdicts on classes of equations, with details; empty in a folder of an earlier version.
    """

    folder: Path
    verdicts: Sequence[TextRow]
    absent: Sequence[TextRow]
    run: dict[str, Any]
    levels: Sequence[TextRow] = ()
    details: Sequence[TextRow] = ()
    classes: Sequence[TextRow] = ()


def save_tables(folder: Path, tables: Mapping[str, "pd.DataFrame"], run: Mapping[str, object]) -> None:
    """Write the tables of a run and ``run.json``, replacing those of an earlier run.

    Parameters
    ----------
    folder : Path
    tables : mapping of str to DataFrame
        Tables by file name.
    run : mapping
    """
    (folder / DETAILS).mkdir(exist_ok=True)
    for name, table in tables.items():
        write_table(_grouped(table) if name == NOT_APPLICABLE else table, folder / name)
    for stale in (folder / DETAILS).iterdir():
        if f"{DETAILS}/{stale.stem}.csv" not in tables and stale.suffix in {".csv", PARQUET}:
            stale.unlink()
    write_json(run, folder / RUN)


def _grouped(absent: "pd.DataFrame") -> "pd.DataFrame":
    """Return the table of cells that do not apply as it is saved: one row for each scheme and reason."""
    import pandas as pd  # noqa: PLC0415 - plugins and workers need no tables

    groups = group_absent({str(name): value for name, value in row.items()} for row in absent.to_dict("records"))
    return pd.DataFrame([group.row for group in groups], columns=[*AbsentGroup._fields])


def read_tables(folder: Path) -> SavedTables:
    """Read all tables of a run.

    Raises
    ------
    UsageError
        If the folder holds no tables, or those of another version of this program.
    """
    details = [row for file in sorted((folder / DETAILS).glob("*.csv")) for row in read_table(file)]
    return read_verdicts(folder)._replace(levels=read_table(folder / LEVELS), details=details)


def read_verdicts(folder: Path) -> SavedTables:
    """Read the tables of a run without levels and details; raises the same errors as `read_tables`."""
    rows, run = read_table(folder / VERDICTS), run_of(folder)
    found = run.get("schema_version")
    if found != SCHEMA:
        told = f"in format {found}" if isinstance(found, int) else "in no known format"
        raise UsageError(
            f"the run in {folder} is {told}, this version of sdaeverify reads format {SCHEMA}: run it again"
        )
    if unknown := {row.get("verdict", "") for row in rows} - {*Verdict}:
        raise UsageError(f"{folder / VERDICTS} has an unknown verdict: {min(unknown)!r:.200}")
    verdicts = [row for row in rows if class_in(row["problem"]) is None]
    details = read_table(folder / CLASSES) if (folder / CLASSES).is_file() else ()
    classes = joined_classes((row for row in rows if class_in(row["problem"]) is not None), details)
    absent = ungroup_absent(read_table(folder / NOT_APPLICABLE, AbsentGroup._fields))
    return SavedTables(folder, verdicts, absent, run, classes=classes)


def class_in(problem: str) -> str | None:
    """Return the class of equations that a label in the column of problems names; None for a problem."""
    if problem.partition("[")[0] != EVERY_EQUATION:
        return None
    return text_of((parse_label(problem).parameters or {}).get("of", GENERAL))


def joined_classes(rows: Iterable[Mapping[str, Any]], details: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return verdicts on classes as rows with the name of the class and the details.

    Parameters
    ----------
    rows, details : iterable of mapping
        Rows of verdicts on classes, and rows of details.
    """
    known = {key_of(row): row for row in details}
    return [{**known.get(key_of(row), {}), **row, "class": class_in(row["problem"])} for row in rows]


def require_run_folder(folder: Path, option: str = "--out") -> None:
    """Create the folder of a run if it does not exist, and check that files can be written into it.

    The check protects a ``run.json`` of another program from being overwritten.

    Parameters
    ----------
    folder : Path
        Folder of the run, which need not exist.
    option : str
        Command line option that gives the folder, for the message.

    Raises
    ------
    UsageError
        If the folder cannot be written into, or has a ``run.json`` without the keys that this program writes.
    """
    file = folder / RUN
    # Unlike Path.is_file, this does not raise for names that no file can have.
    if os.path.isfile(file) and not {"schema_version", "settings"} <= run_of(folder).keys():
        raise UsageError(f"{file} belongs to no run of this program and is left as it is; choose another {option}")
    require_writable(folder, option)


def key_of(row: Mapping[str, Any]) -> Key:
    """Return the key of a row."""
    return Key(*(str(row[name]) for name in NAMES))


def key_in(cell: "Cell", quantity: str) -> Key:
    """Return the key of a quantity in a cell."""
    return Key(cell.scheme.label, cell.spec.label, cell.measure.name, quantity)


def read_table(file: Path, names: Sequence[str] = NAMES) -> Sequence[TextRow]:
    """Return the rows of a table in the folder of a run, as texts.

    Parameters
    ----------
    file : Path
    names : sequence of str
        Required columns.

    Raises
    ------
    UsageError
        If the table cannot be read, or lacks a required column.
    """
    try:
        rows = read_rows(file)
    except (OSError, ValueError, csv.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"{file.parent} holds no run: cannot read {file.name}: {why}; {MAKE}") from error
    if rows and (lacking := {*names} - {*rows[0]}):
        raise UsageError(f"{file} is not a table of this program: it lacks {', '.join(sorted(lacking))}")
    return rows


def run_of(folder: Path) -> dict[str, Any]:
    """Return the contents of ``run.json`` in the folder of a run.

    Raises
    ------
    UsageError
        If the folder holds no run, or the file is not one that this program writes.
    """
    file = folder / RUN
    try:
        run = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        why = error.strerror or error
        raise UsageError(f"{file.parent} holds no run: cannot read {file.name}: {why}; {MAKE}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is not valid JSON: {error}") from error
    if not isinstance(run, dict):
        raise UsageError(f"{file} does not describe a run in the format of this program: {type(run).__name__}")
    return run
