"""Files of a run, each written as a whole or not at all; text only, so that anybody can read them safely."""

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from ..errors import UsageError


def require_writable(folder: Path) -> None:
    """Create a folder if there is none, and check that files can be written into it.

    Raises
    ------
    UsageError
        If it cannot be created or written into.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror or error}; choose another --out") from error


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, numbers with all their digits."""
    write_text(table.to_csv(index=False, lineterminator="\n"), path)


def write_json(values: Mapping[str, object], path: Path) -> None:
    """Write a mapping as JSON."""
    write_text(json.dumps(values, indent=2) + "\n", path)


def write_text(text: str, path: Path) -> None:
    """Write a file beside its place and move it there, so that no reader ever finds half of it.

    Raises
    ------
    UsageError
        If it cannot be written, for example because the disk is full.
    """
    try:
        _replace(text, path)
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error


def _replace(text: str, path: Path) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
