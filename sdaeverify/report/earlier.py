"""What a folder tells of earlier runs: their rows on other cells stay when another run is saved there.

Each row has its seed and the command that makes it again; ``run.json`` lists the runs that rows are left of. Rows of
code that has changed since are not kept: they would be about something else than they say.
"""

import csv
import io
import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from .files import csv_text, harmless, write_json, write_text
from .folders import LEVELS, RUN, VERDICTS
from .saved import EARLIER

KINDS = ("schemes", "problems", "measures")
COLUMNS = ("scheme", "problem", "measure")

# Scheme, problem and measure, as they stand in a table.
Key = tuple[str, ...]
Row = Mapping[str, str]


class Kept(NamedTuple):
    """Rows of earlier runs in a folder.

    Attributes
    ----------
    verdicts, levels : sequence of mapping of str to str
    runs : sequence of dict
        That they are of, as ``run.json`` told of them.
    changed : int
        Rows of verdicts that are left out.
    """

    verdicts: Sequence[Row] = ()
    levels: Sequence[Row] = ()
    runs: Sequence[dict[str, Any]] = ()
    changed: int = 0


def save_tables(
    folder: Path, tables: Mapping[str, pd.DataFrame], run: dict[str, object], cells: Collection[Key]
) -> Kept:
    """Write the tables of a run and ``run.json``, with the rows that are kept of earlier ones.

    Parameters
    ----------
    folder : Path
    tables : mapping of str to DataFrame
        By the name of the file.
    run : dict
    cells : collection of (str, str, str)
        Scheme, problem and measure of each cell of the run.

    Returns
    -------
    Kept
    """
    kept = _kept(folder, run, {tuple(str(harmless(name)) for name in cell) for cell in cells})
    for name, rows in ((VERDICTS, kept.verdicts), (LEVELS, kept.levels)):
        write_text(_joined(csv_text(tables[name]), rows), folder / name)
    write_json({**run, **({EARLIER: list(kept.runs)} if kept.runs else {})}, folder / RUN)
    return kept


def read_runs(folder: Path) -> list[dict[str, Any]]:
    """Return what ``run.json`` tells of the latest run and of those that left rows; nothing if it is damaged."""
    try:
        latest = json.loads((folder / RUN).read_text(encoding="utf-8"))
        earlier = latest.pop(EARLIER, [])
        runs = [run for run in (latest, *earlier) if _selection(run)]
    except (OSError, ValueError, AttributeError, TypeError, KeyError, RecursionError):
        return []
    return runs


def _kept(folder: Path, run: dict[str, Any], cells: Collection[Key]) -> Kept:
    # Whatever is saved of a run more than once is its own.
    now = json.loads(json.dumps(run))
    runs = [one for one in read_runs(folder) if one != now]
    owners: dict[Key, dict[str, Any]] = {}
    rows = [row for row in _rows(folder / VERDICTS) if _key(row) not in cells] if runs else []
    for key in dict.fromkeys(map(_key, rows)):
        owner = next((one for one in runs if _holds(one, key)), None)
        if owner is not None and not _changed(owner, run, key):
            owners[key] = owner
    verdicts = [row for row in rows if _key(row) in owners]
    levels = [row for row in _rows(folder / LEVELS) if _key(row) in owners] if owners else []
    left = [one for one in runs if any(one is owner for owner in owners.values())]
    return Kept(verdicts, levels, left, len(rows) - len(verdicts))


def _selection(run: dict[str, Any]) -> tuple[set[str], ...]:
    return tuple({str(harmless(name)) for name in run["selection"][kind]} for kind in KINDS)


def _holds(run: dict[str, Any], key: Key) -> bool:
    return all(name in names for name, names in zip(key, _selection(run), strict=True))


def _changed(owner: dict[str, Any], run: dict[str, Any], key: Key) -> bool:
    """Tell whether the code of a cell was another one: of what this run is not about, nobody knows."""
    then, now = owner.get("code", {}), run["code"]
    if then.get("framework") != now["framework"]:
        return True
    for kind, name in zip(KINDS, key, strict=True):
        known = {str(harmless(label)): digest for label, digest in now.get(kind, {}).items()}
        before = {str(harmless(label)): digest for label, digest in then.get(kind, {}).items()}
        if name in known and known[name] != before.get(name):
            return True
    return False


def _key(row: Row) -> Key:
    return tuple(row[name] for name in COLUMNS)


def _rows(file: Path) -> list[Row]:
    """Return the rows of a table as texts; none where it is no table of this program."""
    try:
        with file.open(newline="", encoding="utf-8") as opened:
            reader = csv.DictReader(opened, restkey="", restval="", strict=True)
            rows = list(reader) if {*COLUMNS} <= {*(reader.fieldnames or ())} else []
    except (OSError, ValueError, csv.Error):
        return []
    return [row for row in rows if "" not in row]


def _joined(text: str, rows: Sequence[Row]) -> str:
    """Return a table with further rows below it, as they stand in another one."""
    if not rows:
        return text
    table = list(csv.reader(io.StringIO(text)))
    head = list(dict.fromkeys((*table[0], *(name for row in rows for name in row))))
    blank = [""] * (len(head) - len(table[0]))
    told = io.StringIO()
    writer = csv.writer(told, lineterminator="\n")
    writer.writerows(_with_head(head, ([*row, *blank] for row in table[1:]), rows))
    return told.getvalue()


def _with_head(head: list[str], own: Iterable[list[str]], rows: Sequence[Row]) -> list[list[str]]:
    return [head, *own, *([row.get(name, "") for name in head] for row in rows)]
