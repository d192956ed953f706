"""The evidence on the lanes of a problem in one file: a database with a row for each, which is there or is not.

Worker processes write to it, and other programs read it at the same time. What a process was writing when it was
killed is undone by the next one that opens the file. Nothing in the file is executed: of another table, a view or a
trigger nothing is read.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from .lanes import LARGEST, StoredLane, pack_lane, unpack_lane

SUFFIX = ".sqlite"
TABLE = "CREATE TABLE lanes (name TEXT PRIMARY KEY, content BLOB NOT NULL) WITHOUT ROWID"
# Half of a page is lost with each lane.
PAGE = 1024
# Seconds to wait for another process that writes.
PATIENCE = 60.0


class Container(NamedTuple):
    """A file with the evidence on lanes by name.

    Attributes
    ----------
    path : Path
    """

    path: Path

    def read(self, name: str) -> tuple[StoredLane | None, bool]:
        """Return the evidence of a name, None if there is none, and whether what is there is damaged."""
        found = self._read("SELECT content FROM lanes WHERE name = ?", name)
        if not found:
            return None, found is None and self.path.exists()
        lane = unpack_lane(found[0][0])
        return lane, lane is None

    def lanes(self) -> Iterator[tuple[str, StoredLane | None]]:
        """Yield names and evidence; None for what is damaged.

        A file that is none of this program is one damaged lane without a name.
        """
        names = self._read("SELECT name FROM lanes ORDER BY name")
        if names is None:
            yield "", None
        for (name,) in names or ():
            yield name, self.read(name)[0]

    def write(self, name: str, changed: Callable[[StoredLane | None], StoredLane]) -> None:
        """Write the evidence that something makes of what is there; a damaged file is replaced.

        Raises
        ------
        OSError
            If it cannot be written, for example because the disk is full.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if self.path.is_symlink() and not self.path.is_file():
            self.path.unlink()
        try:
            try:
                self._write(name, changed)
            except sqlite3.OperationalError:
                raise
            except sqlite3.DatabaseError:
                self.path.unlink()
                self._write(name, changed)
        except sqlite3.Error as error:
            raise OSError(str(error)) from error

    def _write(self, name: str, changed: Callable[[StoredLane | None], StoredLane]) -> None:
        with _open_database(self.path, "rwc") as file:
            found = file.execute("SELECT content FROM lanes WHERE name = ?", (name,)).fetchone()
            content = pack_lane(changed(unpack_lane(found[0]) if found else None))
            file.execute("INSERT OR REPLACE INTO lanes VALUES (?, ?)", (name, content))

    def _read(self, query: str, *values: object) -> list[Any] | None:
        """Return the rows of a query; None if the file is not there, or none of this program."""
        try:
            with _open_database(self.path, "rw") as file:
                rows: list[Any] = file.execute(query, values).fetchall()
                return rows
        except (OSError, sqlite3.Error):
            return None


def containers(folder: Path) -> list[Container]:
    """Return the files of evidence in a folder, in the order of their names."""
    return [Container(path) for path in sorted(folder.glob(f"*{SUFFIX}"))]


@contextmanager
def _open_database(path: Path, mode: str) -> Iterator[sqlite3.Connection]:
    """Give a database within one transaction, which nothing but the lanes is in."""
    # What is no file, such as a pipe, might never come to an end.
    if mode == "rw" and not path.is_file():
        raise FileNotFoundError(path)
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    with closing(sqlite3.connect(uri, timeout=PATIENCE, isolation_level=None, uri=True)) as file:
        file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST)
        # A machine that fails may damage the file: it is computed again then.
        file.executescript(f"PRAGMA page_size = {PAGE}; PRAGMA synchronous = OFF; PRAGMA trusted_schema = OFF")
        file.execute("BEGIN" if mode == "rw" else "BEGIN IMMEDIATE")
        tables = [sql for (sql,) in file.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")]
        if not tables and mode == "rwc":
            file.execute(TABLE)
        elif tables != [TABLE]:
            raise sqlite3.DatabaseError("another format")
        yield file
        file.execute("COMMIT")
