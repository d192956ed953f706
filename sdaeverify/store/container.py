"""Evidence on the lanes of a problem in one file: a database with one row per lane, written atomically.

Worker processes write to it while other programs read it. The next process that opens the file rolls back a write
that was interrupted. A file that contains anything but the expected table, such as a view or a trigger, is not read.
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from ..errors import UsageError
from .lanes import LARGEST, StoredLane, pack_lane, unpack_lane

SUFFIX = ".sqlite"
TABLE = "CREATE TABLE lanes (name TEXT PRIMARY KEY, content BLOB NOT NULL) WITHOUT ROWID"
ONE, ALL = "SELECT name, content FROM lanes WHERE name = ?", "SELECT name, content FROM lanes ORDER BY name"
# Half of a page is wasted per lane on average.
PAGE = 1024
# Seconds to wait for a lock held by another process.
PATIENCE = 60.0
# Returns new evidence, given the stored evidence or None.
Change = Callable[[StoredLane | None], StoredLane]


def containers(folder: Path) -> list[Path]:
    """Return the files of evidence in a folder, in the order of their names."""
    return sorted(folder.glob(f"*{SUFFIX}"))


def all_lanes(path: Path) -> Iterator[tuple[str, StoredLane | None]]:
    """Yield names and evidence; None for damaged evidence and, with an empty name, for an unreadable file."""
    for name, content in _read(path, [(ALL, ())], [("", b"")]):
        yield name, unpack_lane(content)


def read_lanes(path: Path, names: Iterable[str]) -> dict[str, StoredLane | None]:
    """Return the stored evidence for the given names, without those that are absent; None for damaged evidence."""
    if not path.exists():
        return {}
    named = [(name,) for name in names]
    rows = _read(path, [(ONE, name) for name in named], [(*name, b"") for name in named])
    return {name: unpack_lane(content) for name, content in rows}


def write_lanes(path: Path, changes: Mapping[str, Change]) -> None:
    """Update the evidence of several lanes in one transaction; a damaged file is replaced.

    Raises
    ------
    UsageError
        If the file cannot be written, for example because the disk is full.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_symlink() and not path.is_file():
            path.unlink()
        try:
            _write(path, changes)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError:
            path.unlink()
            _write(path, changes)
    except (OSError, sqlite3.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot write {path}: {reason}; choose another --out") from error


def _write(path: Path, changes: Mapping[str, Change]) -> None:
    with _open_database(path, "rwc") as file:
        for name, change in changes.items():
            found = file.execute(ONE, (name,)).fetchone()
            content = pack_lane(change(unpack_lane(found[1]) if found else None))
            file.execute("INSERT OR REPLACE INTO lanes VALUES (?, ?)", (name, content))


def _read(path: Path, queries: Iterable[tuple[str, tuple[str, ...]]], damaged: list[Any]) -> list[Any]:
    """Return the rows of queries, or `damaged` if the file is missing or has another format."""
    try:
        with _open_database(path, "rw") as file:
            return [row for query in queries for row in file.execute(*query)]
    except (OSError, sqlite3.Error):
        return damaged


@contextmanager
def _open_database(path: Path, mode: str) -> Iterator[sqlite3.Connection]:
    """Open a database within one transaction, after checking that it contains only the table of lanes."""
    # Reading other kinds of files, such as pipes, may block.
    if mode == "rw" and not path.is_file():
        raise FileNotFoundError(path)
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    with closing(sqlite3.connect(uri, timeout=PATIENCE, isolation_level=None, uri=True)) as file:
        file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST)
        # A system crash may damage the file without synchronisation; its evidence is then computed again.
        file.executescript(f"PRAGMA page_size = {PAGE}; PRAGMA synchronous = OFF; PRAGMA trusted_schema = OFF")
        file.execute("BEGIN" if mode == "rw" else "BEGIN IMMEDIATE")
        tables = [sql for (sql,) in file.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")]
        if not tables and mode == "rwc":
            file.execute(TABLE)
        elif tables != [TABLE]:
            raise sqlite3.DatabaseError("another format")
        yield file
        file.execute("COMMIT")
