"""What a folder tells of earlier runs: their rows on other cells stay when another run is saved there.

Each row of verdicts names its run; ``run.json`` lists the runs that rows are left of. Rows of
code that has changed since are not kept: they would be about something else than they say.
Tables of another version of this program are moved into a folder beside the new ones as they are.
"""

import csv
import io
import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import UsageError
from .files import PARQUET, csv_text, harmless, read_rows, write_csv, write_json
from .folders import DETAILS, LEVELS, NOT_APPLICABLE, RUN, SCHEMA, VERDICTS
from .html import PAGE
from .saved import EARLIER
from .tables.columns import COLUMNS as DICTIONARY

# Folders for what was left by another version.
ASIDE = "other-version"
KINDS = ("schemes", "problems", "measures")
COLUMNS = ("scheme", "problem", "measure")

# Scheme, problem and measure, as they stand in a table.
Key = tuple[str, ...]
Row = Mapping[str, str]


class Kept(NamedTuple):
    """Rows of earlier runs in a folder.

    Attributes
    ----------
    rows : mapping of str to sequence of mapping of str to str
        By the name of the file.
    runs : sequence of dict
        That they are of, as ``run.json`` told of them.
    changed : int
        Rows of verdicts that are left out.
    aside : Path or None
        The folder that the tables of another version of this program were moved into.
    """

    rows: Mapping[str, Sequence[Row]] = {}
    runs: Sequence[dict[str, Any]] = ()
    changed: int = 0
    aside: Path | None = None

    @property
    def verdicts(self) -> int:
        """Number of rows of verdicts."""
        return len(self.rows.get(VERDICTS, ()))


def save_tables(
    folder: Path, tables: Mapping[str, Mapping[str, Iterable[object]]], run: dict[str, object], cells: Collection[Key]
) -> Kept:
    """Write the tables of a run and ``run.json``, with the rows that are kept of earlier ones.

    Parameters
    ----------
    folder : Path
    tables : mapping of str to (mapping of str to iterable)
        Columns by the name of the file.
    run : dict
    cells : collection of (str, str, str)
        Scheme, problem and measure of each cell of the run.

    Returns
    -------
    Kept

    Raises
    ------
    UsageError
        If tables of another version cannot be moved out of the way.
    """
    aside = _move_aside(folder)
    kept = _keep(folder, run, {tuple(str(harmless(name)) for name in cell) for cell in cells})
    (folder / DETAILS).mkdir(exist_ok=True)
    for name in (*tables, *(name for name in kept.rows if name not in tables)):
        rows = kept.rows.get(name, ())
        write_csv(_join(csv_text(tables[name]) if name in tables else "", rows), folder / name)
    for stale in (folder / DETAILS).iterdir():
        if f"{DETAILS}/{stale.stem}.csv" not in {*tables, *kept.rows} and stale.suffix in {".csv", PARQUET}:
            stale.unlink()
    write_json({**run, **({EARLIER: list(kept.runs)} if kept.runs else {})}, folder / RUN)
    return kept._replace(aside=aside)


def _move_aside(folder: Path) -> Path | None:
    """Move the tables of a run that is not one of this version into a folder; None if there are none."""
    if read_runs(folder) or not (folder / VERDICTS).is_file():
        return None
    target = next(place for n in count(1) if not (place := folder / f"{ASIDE}-{n}").exists())
    tables = (VERDICTS, NOT_APPLICABLE, LEVELS)
    names = (*tables, *(Path(name).with_suffix(PARQUET).name for name in tables), DICTIONARY, RUN, DETAILS, PAGE)
    try:
        target.mkdir()
        for name in names:
            if (folder / name).exists():
                (folder / name).rename(target / name)
    except OSError as error:
        why = error.strerror or error
        raise UsageError(f"cannot move {folder / VERDICTS}: {why}; choose another --out") from error
    return target


def read_runs(folder: Path) -> list[dict[str, Any]]:
    """Return what ``run.json`` tells of the latest run and of those that left rows; nothing if it is damaged."""
    try:
        latest = json.loads((folder / RUN).read_text(encoding="utf-8"))
        earlier = latest.pop(EARLIER, [])
        runs = [latest, *earlier] if latest["schema_version"] == SCHEMA else []
    except (OSError, ValueError, AttributeError, TypeError, KeyError, RecursionError):
        return []
    return [run for run in runs if isinstance(run, dict)]


def _keep(folder: Path, run: dict[str, Any], cells: Collection[Key]) -> Kept:
    # Whatever is saved of a run more than once is its own.
    now, runs = json.loads(json.dumps(run)), read_runs(folder)
    rows = _rows_of_others(folder, (VERDICTS, NOT_APPLICABLE), cells) if runs else {}
    owners: dict[Key, int] = {}
    for row in (*rows.get(VERDICTS, ()), *rows.get(NOT_APPLICABLE, ())):
        place = int(row["run"]) if row.get("run", "").isdecimal() else len(runs)
        if place < len(runs) and runs[place] != now and not _has_changed(runs[place], run, _key(row)):
            owners[_key(row)] = place
    # Nobody looks for further rows of cells of which none is kept.
    rows |= _rows_of_others(folder, (LEVELS, *_details(folder)), cells) if owners else {}
    places = sorted({*owners.values()})
    new = {key: str(1 + places.index(place)) for key, place in owners.items()}
    kept = {name: [_of_run(row, new[_key(row)]) for row in of if _key(row) in new] for name, of in rows.items()}
    lost = len(rows.get(VERDICTS, ())) - len(kept.get(VERDICTS, ()))
    return Kept({name: of for name, of in kept.items() if of}, [runs[place] for place in places], lost)


def _rows_of_others(folder: Path, names: Iterable[str], cells: Collection[Key]) -> dict[str, list[Row]]:
    """Return the rows of tables that are about other cells, by the names of their files."""
    return {name: [row for row in _rows(folder / name) if _key(row) not in cells] for name in names}


def _details(folder: Path) -> Iterator[str]:
    return (f"{DETAILS}/{file.name}" for file in sorted((folder / DETAILS).glob("*.csv")))


def _of_run(row: Row, place: str) -> Row:
    return {**row, "run": place} if "run" in row else row


def _has_changed(owner: dict[str, Any], run: dict[str, Any], key: Key) -> bool:
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


def _rows(file: Path) -> Sequence[Row]:
    """Return the rows of a table as texts; none where it is no table of this program."""
    try:
        rows = read_rows(file)
    except (OSError, ValueError, csv.Error):
        return []
    return [row for row in rows if "" not in row] if rows and {*COLUMNS} <= {*rows[0]} else []


def _join(text: str, rows: Sequence[Row]) -> str:
    """Return a table with further rows below it, as they stand in another one."""
    if not rows:
        return text
    if not text:
        text = ",".join(rows[0]) + "\n"
    table = list(csv.reader(io.StringIO(text)))
    head = list(dict.fromkeys((*table[0], *(name for row in rows for name in row))))
    blank = [""] * (len(head) - len(table[0]))
    told = io.StringIO()
    writer = csv.writer(told, lineterminator="\n")
    writer.writerows(_with_head(head, ([*row, *blank] for row in table[1:]), rows))
    return told.getvalue()


def _with_head(head: list[str], own: Iterable[list[str]], rows: Sequence[Row]) -> list[list[str]]:
    return [head, *own, *([row.get(name, "") for name in head] for row in rows)]
