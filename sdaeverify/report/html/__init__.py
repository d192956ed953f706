"""The HTML page of a run: one file without network access, with pictures drawn from the tables."""

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
from ..folders import SavedTables, read_tables
from ..pictures import description
from ..tables.columns import COLUMNS
from .large import ABOVE, FOLDER, is_large, overview, problem_pages, remove_problem_pages
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
# Reports on the verifier itself, in sibling folders of the run.
VERIFIER = {"kills": Path("selftest", "kill.csv"), "calibration": Path("calibration", "calibration.csv")}
MEANING = "What the columns of the tables beside this page mean."
# Digits of a number in a table on the page; the CSV file has all digits.
DIGITS = 5
# Formats of pictures that a page can embed.
EMBEDDED = {".svg": "image/svg+xml", ".png": "image/png"}
# Content security policy: the page has no relative addresses and sends no forms.
NOWHERE = "base-uri 'none'; form-action 'none'"
SCRIPTS = ("plots.js", "data.js", "pages.js", "classes.js", "passports.js", "start.js")


class TablePage(NamedTuple):
    """A table with its own page; cells are numbers or texts."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]
    text: Sequence[str] = ()
    picture: str = ""

    @classmethod
    def of(
        cls, title: str, table: "pd.DataFrame", text: Sequence[str] = (), picture: Path | None = None
    ) -> "TablePage":
        """Convert a table: missing cells become empty, numbers are rounded to `DIGITS` digits.

        Parameters
        ----------
        title : str
        table : DataFrame
        text : sequence of str, optional
            Notes above the table, a paragraph each.
        picture : Path, optional
            Picture in SVG or PNG, which is embedded in the page; other formats are omitted.
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
    """Write the page of a run and return its path; for a large run, an overview and a page for each problem.

    Parameters
    ----------
    folder : Path
        Folder with the tables of the run.
    passports : mapping, optional
        See `payload`.

    Raises
    ------
    UsageError
        If the folder holds no run, or cannot be written into.
    """
    path, saved = folder / PAGE, read_tables(folder)
    known, columns = (
        {name: _read_csv(folder.parent / file) for name, file in VERIFIER.items()},
        _read_csv(folder / COLUMNS),
    )
    further = {"verifier": known} if any(known.values()) else {}
    tables = [TablePage("Columns", columns[0], columns[1:], (MEANING,))._asdict()] if columns else []
    data = _write_parts(folder, saved, passports or {}) if is_large(saved) else payload(saved, passports)
    remove_problem_pages(folder, {*data.get("parts", {}).values()})
    write_text(page_text({**data, **further, "tables": tables}), path)
    return path


def _write_parts(folder: Path, saved: SavedTables, passports: Mapping[str, Any]) -> dict[str, Any]:
    """Write the pages of the problems of a large run, and return the data of its overview."""
    (folder / FOLDER).mkdir(exist_ok=True)
    for part in problem_pages(saved, passports):
        write_text(page_text({**payload(part.tables, part.passports), "above": ABOVE}), folder / part.file)
    return overview(payload(saved._replace(levels=(), details=()), passports))


def write_tables(folder: Path, sentence: str, tables: Sequence[TablePage]) -> Path:
    """Write a page that consists of tables only into a folder, and return its path.

    Parameters
    ----------
    folder : Path
    sentence : str
        Sentence at the top of the page.
    tables : sequence of TablePage
        Tables, each of which becomes a section of the page.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    nothing: dict[str, Any] = {"run": {}, "findings": {}, "levels": [], "absent": {}}
    shown = [table._asdict() for table in tables]
    page = folder / PAGE
    write_text(page_text({**nothing, "sentence": sentence, "tables": shown}), page)
    return page


def remove_page(folder: Path) -> None:
    """Remove the page of an earlier run, and its pages of problems.

    Raises
    ------
    UsageError
        If the page cannot be removed.
    """
    try:
        (folder / PAGE).unlink(missing_ok=True)
        remove_problem_pages(folder, set())
    except OSError as error:
        raise UsageError(f"cannot remove {folder / PAGE}: {error.strerror or error}") from error


def page_text(data: Mapping[str, Any]) -> str:
    """Return the HTML text of a page from its data.

    Parameters
    ----------
    data : mapping
        Data as returned by `payload`.
    """
    script = "\n".join(_asset(name) for name in SCRIPTS)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; img-src data:; {NOWHERE}"
    # Only "<" could close the script element.
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
    # Parts are at odd indices; placeholders inside a part are not replaced.
    return "".join(parts[piece] if place % 2 else piece for place, piece in enumerate(pieces))


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _read_csv(file: Path) -> list[list[str]]:
    """Return the rows of a table, heading first; empty if there is no such table."""
    try:
        with file.open(newline="", encoding="utf-8") as opened:
            return list(csv.reader(opened))
    except (OSError, ValueError, csv.Error):
        return []
