"""Files of a run, each written as a whole or not at all; text only, so that anybody can read them safely."""

import csv
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import IO

import pandas as pd

from ..errors import UsageError
from .plain import visible

PARQUET = ".parquet"
UNFINISHED = ".unfinished-"
# What a spreadsheet takes for the beginning of a formula, full-width signs included.
FORMULA = tuple("=+-@\uff1d\uff0b\uff0d\uff20")


@contextmanager
def write_whole(path: Path) -> Iterator[IO[bytes]]:
    """Give a file to write to, beside its place, and move it there at the end: no reader ever finds half of it.

    Parameters
    ----------
    path : Path
        In a folder that exists; what is there is replaced, or left as it is if writing fails.
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
    """Create a folder if there is none, and check that files can be written into it.

    Parameters
    ----------
    folder : Path
    option : str
        That names it on the command line, for the message.

    Raises
    ------
    UsageError
        If it cannot be created or written into.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot write into {folder}: {why}; choose another {option}") from error


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, and as Parquet beside it where pyarrow is installed.

    Numbers have all digits, nothing stands for None and NaN, and texts, headings too, are `harmless`.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    texts = table.select_dtypes(exclude=["number", "bool"]).map(harmless)
    safe = table.assign(**{str(name): column for name, column in texts.items()}).rename(columns=harmless)
    write_text(safe.to_csv(index=False, lineterminator="\n"), path)
    if find_spec("pyarrow"):
        # A column of Parquet has one type.
        mixed = safe.select_dtypes("object").astype("string")
        _write(lambda file: safe.assign(**mixed).to_parquet(file, index=False), path.with_suffix(PARQUET))


def harmless(value: object) -> object:
    """Return the value of a cell such that neither a terminal nor a spreadsheet takes it for an order.

    Numbers and other values that are no text stay as they are. In texts, control characters become escapes; a text
    that a spreadsheet would evaluate, since ``=``, ``+``, ``-`` or ``@`` is the first thing in it, gets an apostrophe
    in front, which a spreadsheet does not show. A text that is a number is none of these.
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
    """Return the rows of a CSV file that `write_table` has written.

    Raises
    ------
    OSError, ValueError, csv.Error
        If it cannot be read, is empty, ends within a line, or has a row of another number of cells than the heading.
    """
    with file.open(newline="", encoding="utf-8") as opened:
        text = opened.read()
    if not text.endswith("\n"):
        raise ValueError("the file is cut: its last line has no end" if text else "the file is empty")
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
        If it cannot be written, for example because the disk is full.
    """
    _write(lambda file: file.write(text.encode()), path)


def _write(write: Callable[[IO[bytes]], object], path: Path) -> None:
    try:
        with write_whole(path) as file:
            write(file)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error
