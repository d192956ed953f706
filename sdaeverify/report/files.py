"""Files of a run, each written as a whole or not at all; text only, so that anybody can read them safely."""

import csv
import io
import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from errno import EISDIR
from importlib.util import find_spec
from itertools import zip_longest
from pathlib import Path
from types import NoneType
from typing import IO, TYPE_CHECKING, Any

from ..errors import UsageError
from .plain import visible

if TYPE_CHECKING:
    import pandas as pd

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


def require_writable_file(file: Path, option: str) -> None:
    """Create the folder of a file if there is none, and check that the file can be written.

    Raises
    ------
    UsageError
        If it cannot, for example because it is a folder.
    """
    require_writable(file.parent, option)
    try:
        is_folder = file.is_dir()
    except OSError as error:
        raise UsageError(f"cannot write {file}: {error.strerror or error}; choose another {option}") from error
    if is_folder:
        raise UsageError(f"cannot write {file}: {os.strerror(EISDIR)}; choose another {option}")


def write_table(table: "pd.DataFrame", path: Path) -> None:
    """Write a table as CSV, as `csv_text` returns it."""
    known = table.astype(object).where(table.notna(), None)
    write_text(csv_text({str(name): column.tolist() for name, column in known.items()}), path)


def write_csv(text: str, path: Path) -> None:
    """Write a table as CSV, and as Parquet beside it where pyarrow is installed.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    write_text(text, path)
    if find_spec("pyarrow"):
        import pandas as pd  # noqa: PLC0415 - it takes as long as all the rest of the program

        texts = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
        table = texts.apply(_convert_column)
        try:
            with write_whole(path.with_suffix(PARQUET)) as file:
                table.to_parquet(file, index=False)
        except OSError as error:
            raise UsageError(f"cannot write {path.with_suffix(PARQUET)}: {error.strerror or error}") from error


def _convert_column(column: "pd.Series[Any]") -> "pd.Series[Any]":
    """Return a column of texts as whole numbers, else as numbers, to the last bit; as it is if it is neither."""
    import pandas as pd  # noqa: PLC0415

    for number in (int, lambda text: float(text or "nan")):
        try:
            return pd.Series([number(text) for text in column], index=column.index)
        except ValueError:
            continue
    return column


def csv_text(columns: Mapping[str, Iterable[object]]) -> str:
    """Return columns as CSV: numbers with all digits, nothing for None and NaN; texts, headings too, are `harmless`.

    Parameters
    ----------
    columns : mapping of str to iterable
        By their headings, all of one length.
    """
    told = io.StringIO()
    writer = csv.writer(told, lineterminator="\n")
    writer.writerow([harmless(name) for name, _ in columns.items()])
    writer.writerows(zip(*(_cells(list(values)) for _, values in columns.items()), strict=True))
    return told.getvalue()


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


def _cells(values: list[object]) -> list[object]:
    kinds = {*map(type, values)}
    if any(issubclass(kind, str) for kind in kinds):
        # Most texts stand in many rows.
        safe = {text: harmless(text) for text in {value for value in values if isinstance(value, str)}}
        values = [safe[value] if isinstance(value, str) else value for value in values]
    if kinds - {str, int, bool, NoneType}:
        return [None if value != value else value for value in values]  # noqa: PLR0124 - NaN
    return values


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def read_rows(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file, with nothing where one is too short; what is too much has no heading.

    Raises
    ------
    OSError, ValueError, csv.Error
        If it cannot be read.
    """
    with file.open(newline="", encoding="utf-8") as opened:
        reader = csv.reader(opened, strict=True)
        head = next(reader, [])
        return [_read_row(head, line) for line in reader if line]


def _read_row(head: list[str], line: list[str]) -> dict[str, str]:
    return dict(zip(head, line, strict=True) if len(head) == len(line) else zip_longest(head, line, fillvalue=""))


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
    try:
        with write_whole(path) as file:
            file.write(text.encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error
