"""The page of a run: one file that needs no network, its pictures drawn from the numbers of the tables."""

import base64
import csv
import hashlib
import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...errors import UsageError
from ..files import write_text
from ..folders import read_tables
from ..pictures import description
from ..tables.columns import COLUMNS
from .payload import payload, to_json

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "PAGE",
    "TablePage",
    "page_text",
    "payload",
    "remove_page",
    "to_json",
    "write_page",
    "write_tables",
]


PAGE = "report.html"
# What is known of the verifier itself, from the reports beside a run.
VERIFIER = {"kills": Path("selftest", "kill.csv"), "calibration": Path("calibration", "calibration.csv")}
MEANING = "What the columns of the tables beside this page mean."
# Of a number in a table that stands on a page; the file beside it has all of them.
DIGITS = 5
# Pictures that a page can hold.
EMBEDDED = {".svg": "image/svg+xml", ".png": "image/png"}
# What a page without addresses of its own needs least: neither a base for them nor anywhere to send a form.
NOWHERE = "base-uri 'none'; form-action 'none'"
SCRIPTS = ("plots.js", "data.js", "pages.js", "classes.js", "passports.js", "start.js")


class TablePage(NamedTuple):
    """A table with a page of its own: numbers where a cell is a number, texts elsewhere."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]
    text: Sequence[str] = ()
    picture: str = ""

    @classmethod
    def of(
        cls, title: str, table: "pd.DataFrame", text: Sequence[str] = (), picture: Path | None = None
    ) -> "TablePage":
        """Return the page of a table: what is missing is empty, numbers have as many digits as a reader uses.

        Parameters
        ----------
        title : str
        table : DataFrame
        text : sequence of str, optional
            Notes above the table, a paragraph each.
        picture : Path, optional
            A file in SVG or PNG, which becomes a part of the page; one of another kind is left out.
        """
        rows = [[_readable(cell) for cell in row] for row in table.itertuples(index=False)]
        return cls(title, list(table.columns), rows, text, _embedded(picture))


def _readable(cell: object) -> str | float:
    if isinstance(cell, float):
        return "" if isnan(cell) else float(f"{cell:.{DIGITS}g}") if isfinite(cell) else str(cell)
    return "" if cell is None else str(cell)


def _embedded(picture: Path | None) -> str:
    kind = EMBEDDED.get(picture.suffix, "") if picture else ""
    return f"data:{kind};base64,{base64.b64encode(picture.read_bytes()).decode()}" if picture and kind else ""


def write_page(folder: Path, passports: Mapping[str, Any] | None = None) -> Path:
    """Write the page of the run in a folder, and return its path.

    Parameters
    ----------
    folder : Path
        With the tables of the run.
    passports : mapping, optional
        See `payload`.

    Raises
    ------
    UsageError
        If the folder holds no run, or cannot be written into.
    """
    path = folder / PAGE
    known, columns = (
        {name: _read_csv(folder.parent / file) for name, file in VERIFIER.items()},
        _read_csv(folder / COLUMNS),
    )
    further = {"verifier": known} if any(known.values()) else {}
    tables = [TablePage("Columns", columns[0], columns[1:], (MEANING,))._asdict()] if columns else []
    write_text(page_text({**payload(read_tables(folder), passports), **further, "tables": tables}), path)
    return path


def write_tables(file: Path, sentence: str, tables: Sequence[TablePage]) -> None:
    """Write a page of tables alone.

    Parameters
    ----------
    file : Path
    sentence : str
        What stands at the top.
    tables : sequence of TablePage
        A part of the page each.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    nothing: dict[str, Any] = {"run": {}, "findings": {}, "levels": [], "absent": {}}
    shown = [table._asdict() for table in tables]
    write_text(page_text({**nothing, "sentence": sentence, "tables": shown}), file)


def remove_page(folder: Path) -> None:
    """Remove the page of an earlier run.

    Raises
    ------
    UsageError
        If it cannot be removed.
    """
    try:
        (folder / PAGE).unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(f"cannot remove {folder / PAGE}: {error.strerror or error}") from error


def page_text(data: Mapping[str, Any]) -> str:
    """Return the page that shows some numbers.

    Parameters
    ----------
    data : mapping
        As `payload` returns it.
    """
    script = "\n".join(_asset(name) for name in SCRIPTS)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; img-src data:; {NOWHERE}"
    # Within a script element, only this could end it.
    numbers = json.dumps({**data, "pictures": description()}, separators=(",", ":"), allow_nan=False).replace(
        "<", "\\u003c"
    )
    parts = {
        "policy": escape(policy),
        "style": _asset("page.css"),
        "sentence": escape(str(data.get("sentence", ""))),
        "data": numbers,
        "script": script,
    }
    frame = _asset("page.html")
    pieces = frame.split("%%")
    # Parts stand at odd places; what a part holds is not looked at again.
    return "".join(parts[piece] if place % 2 else piece for place, piece in enumerate(pieces))


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _read_csv(file: Path) -> list[list[str]]:
    """Return the rows of a table, headings first; none where there is no such table."""
    try:
        with file.open(newline="", encoding="utf-8") as opened:
            return list(csv.reader(opened))
    except (OSError, ValueError, csv.Error):
        return []
