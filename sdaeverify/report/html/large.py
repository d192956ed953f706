"""The pages of a large run: an overview without details, and a page with all details for each problem.

The content security policy of a page allows no requests, so a page cannot load details on demand. A page of all
details takes about 570 bytes per quantity and is parsed whole when it is opened. Above `MOST` quantities the page of
the run therefore keeps what summary, matrix and lists show, a tenth of it, and links to the pages of problems.
"""

import re
from collections.abc import Iterator, Mapping
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

from ..cells import grouped
from ..folders import SavedTables
from ..sentences import ATTENTION
from .payload import factorise

# Quantities of a run whose page has all details: such a page has about 11 MB.
# Size: rows of a page.
MOST = 20_000
# Folder of the pages of problems, beside the page of the run, which is one level above them.
FOLDER, ABOVE = "problems", "../report.html"
# Longest part of a label in the name of a file.
LONGEST = 60
# Columns of the findings in an overview; reasons only where attention is needed.
OVERVIEW = (
    "scheme",
    "problem",
    "measure",
    "quantity",
    "verdict",
    "claim",
    "value_of",
    "reason",
    "claimed_order",
    "margin",
    "least",
    "order_value",
    "sampled",
    "seconds",
)
# Parts of the record of a run that only its summary shows.
OF_SUMMARY = ("plugins", "warnings", "versions", "platform")
# Parts of the data that an overview keeps.
KEPT = ("sentence", "run", "classes", "absent", "passports", "reach", "labels")


class ProblemPage(NamedTuple):
    """Data of the page of one problem.

    Attributes
    ----------
    file : str
        Its path, relative to the folder of the run.
    tables : SavedTables
        Rows of the problem.
    passports : dict
        Passports of the problem and of the measures.
    """

    file: str
    tables: SavedTables
    passports: dict[str, Any]


def is_large(tables: SavedTables) -> bool:
    """Return whether a run has too many quantities for a page with all details."""
    return len(tables.verdicts) > MOST


def file_of(problem: str) -> str:
    """Return the path of the page of a problem, relative to the folder of the run; labels may have any character."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", problem)[:LONGEST].strip("-")
    return f"{FOLDER}/{name}-{crc32(problem.encode()):08x}.html"


def problem_pages(tables: SavedTables, passports: Mapping[str, Any]) -> Iterator[ProblemPage]:
    """Yield the data of the page of each problem with a measured or claimed quantity.

    Parameters
    ----------
    tables : SavedTables
    passports : mapping
        Passports of the run.
    """
    by_problem = [
        grouped(rows, itemgetter("problem"))
        for rows in (tables.verdicts, tables.absent, tables.levels, tables.details)
    ]
    run = {name: value for name, value in tables.run.items() if name not in OF_SUMMARY}
    known, measures = passports.get("problems", {}), passports.get("measures", {})
    for problem in by_problem[0]:
        verdicts, absent, levels, details = ([*rows.get(problem, ())] for rows in by_problem)
        own = SavedTables(tables.folder, verdicts, absent, run, levels, details)
        own_passports = {"problems": {problem: known[problem]} if problem in known else {}, "measures": measures}
        yield ProblemPage(file_of(problem), own, own_passports)


def overview(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of a run without details, with the addresses of the pages of problems.

    Parameters
    ----------
    data : mapping
        Result of `payload` for the tables of the run without levels and details.
    """
    findings = {name: data["findings"][name] for name in OVERVIEW}
    verdicts, reasons = (_texts(findings[name]) for name in ("verdict", "reason"))
    shown = (text if verdict in ATTENTION else "" for text, verdict in zip(reasons, verdicts, strict=True))
    findings["reason"] = factorise([*shown])
    problems = findings["problem"]["words"]
    kept = {name: data[name] for name in KEPT}
    return {**kept, "findings": findings, "levels": [], "parts": {name: file_of(name) for name in problems}}


def _texts(column: Mapping[str, Any]) -> list[str]:
    return [column["words"][place] for place in column["at"]]


def remove_problem_pages(folder: Path, kept: set[str]) -> None:
    """Remove the pages of problems in the folder of a run, except some, given by their paths in the folder."""
    for file in (folder / FOLDER).glob("*.html"):
        if f"{FOLDER}/{file.name}" not in kept:
            file.unlink(missing_ok=True)
