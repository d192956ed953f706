"""The tables of a finished run, read from its folder as texts: in a tenth of a second, and nothing is executed."""

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import UsageError

VERDICTS, LEVELS, RUN = "verdicts.csv", "levels.csv", "run.json"
Key = tuple[str, str, str, str]
NAMES = ("scheme", "problem", "measure", "quantity")
TextRow = Mapping[str, str]


class SavedTables(NamedTuple):
    """What a folder holds of a run.

    Attributes
    ----------
    folder : Path
    verdicts, levels : list of mapping of str to str
    run : dict
        The contents of ``run.json``.
    """

    folder: Path
    verdicts: list[TextRow]
    levels: list[TextRow]
    run: dict[str, Any]


def read_tables(folder: Path) -> SavedTables:
    """Read the tables of a run.

    Raises
    ------
    UsageError
        If the folder holds none.
    """
    return SavedTables(folder, _rows(folder / VERDICTS), _rows(folder / LEVELS), _run(folder / RUN))


def key_of(row: TextRow) -> Key:
    """Return what a row is about."""
    scheme, problem, measure, quantity = (row[name] for name in NAMES)
    return scheme, problem, measure, quantity


def _rows(file: Path) -> list[TextRow]:
    try:
        with file.open(newline="", encoding="utf-8") as opened:
            rows: list[TextRow] = list(csv.DictReader(opened, restval="", restkey=""))
    except (OSError, UnicodeError, csv.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"{file.parent} holds no run: cannot read {file.name}: {why}") from error
    if rows and not {*NAMES} <= {*rows[0]}:
        raise UsageError(f"{file} is no table of this program: it lacks {', '.join(sorted({*NAMES} - {*rows[0]}))}")
    return rows


def _run(file: Path) -> dict[str, Any]:
    try:
        run = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"{file.parent} holds no run: cannot read {file.name}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is no JSON: {error}") from error
    if not isinstance(run, dict):
        raise UsageError(f"{file} does not tell of a run as this program writes it: {type(run).__name__}")
    return run
