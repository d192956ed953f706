"""Files of a run: text files that are written atomically."""

import csv
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import IO, TYPE_CHECKING

from ..errors import UsageError
from .plain import visible

if TYPE_CHECKING:
    import pandas as pd

PARQUET = ".parquet"
UNFINISHED = ".unfinished-"
# Characters that begin a formula in a spreadsheet, including full-width signs.
FORMULA = tuple("=+-@\uff1d\uff0b\uff0d\uff20")


@contextmanager
def write_whole(path: Path) -> Iterator[IO[bytes]]:
    """Write a file atomically: yield a temporary file in the same folder, then rename it.

    Parameters
    ----------
    path : Path
        File in an existing folder. An existing file is replaced, or kept if writing fails.
    """
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=UNFINISHED)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def require_writable(folder: Path, option: str = "--out") -> None:
    """Create a folder if it does not exist, and check that files can be written into it.

    Parameters
    ----------
    folder : Path
    option : str
        Command line option that gives the folder, for the message.

    Raises
    ------
    UsageError
        If the folder cannot be created or written into.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot write into {folder}: {why}; choose another {option}") from error


def write_table(table: "pd.DataFrame", path: Path) -> None:
    """Write a table as CSV, and as Parquet if pyarrow is installed.

    Numbers have all digits, None and NaN become empty cells, and texts and headings pass through `harmless`.

    Raises
    ------
    UsageError
        If the table cannot be written.
    """
    texts = table.select_dtypes(exclude=["number", "bool"]).map(harmless)
    safe = table.assign(**{str(name): column for name, column in texts.items()}).rename(columns=harmless)
    write_text(safe.to_csv(index=False, lineterminator="\n"), path)
    if find_spec("pyarrow"):
        # A column of Parquet has one type.
        mixed = safe.select_dtypes("object").astype("string")
        _write(lambda file: safe.assign(**mixed).to_parquet(file, index=False), path.with_suffix(PARQUET))


def harmless(value: object) -> object:
    """Escape the value of a cell so that neither a terminal nor a spreadsheet interprets it as a command.

    Numbers and other values that are not texts stay unchanged. In texts, control characters become escapes. A text
    that begins with ``=``, ``+``, ``-`` or ``@``, which a spreadsheet would evaluate, gets a leading apostrophe,
    which a spreadsheet does not show. A text that is a number gets none.
    """
    if not isinstance(value, str):
        return value
    text = visible(value)
    return f"'{text}" if text.lstrip().startswith(FORMULA) and not _number(text) else text


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def read_rows(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file written by `write_table`.

    Raises
    ------
    OSError, ValueError, csv.Error
        If the file cannot be read, is empty, ends within a line, or has a row whose length differs from the heading.
    """
    with file.open(newline="", encoding="utf-8") as opened:
        text = opened.read()
    if not text.endswith("\n"):
        raise ValueError("the file is truncated: its last line is incomplete" if text else "the file is empty")
    heading, *lines = csv.reader(StringIO(text, newline=""), strict=True)
    for number, cells in enumerate(lines, 2):
        if len(cells) != len(heading):
            raise ValueError(f"row {number} has {len(cells)} cells, the heading {len(heading)}")
    return [dict(zip(heading, cells, strict=True)) for cells in lines]


def write_json(values: Mapping[str, object], path: Path) -> None:
    """Write a mapping as JSON."""
    write_text(json.dumps(values, indent=2) + "\n", path)


def write_text(text: str, path: Path) -> None:
    """Write a text file.

    Raises
    ------
    UsageError
        If the file cannot be written, for example because the disk is full.
    """
    _write(lambda file: file.write(text.encode()), path)


def _write(write: Callable[[IO[bytes]], object], path: Path) -> None:
    try:
        with write_whole(path) as file:
            write(file)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error
