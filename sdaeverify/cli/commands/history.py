"""``history``: runs in a row, their verdicts, what changed between them, errors that made a significant step."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import hypot, isnan
from pathlib import Path
from statistics import NormalDist
from typing import Any

import click

from ...errors import UsageError
from ...report.files import require_writable_file
from ...report.folders import Key, SavedTables, TextRow, key_of, read_tables
from ...report.html import TablePage, rounded, write_tables
from ...report.plain import in_columns, visible
from ...report.reading import number
from ...report.sentences import ABSENT, SYMBOLS, PlainLine
from ..console import output, print_lines
from ..exit_codes import ExitCode
from ..options import once

HISTORY = Path("reports", "history.html")
# Of any step that is marked though nothing has changed, over all that are compared.
ALPHA = 0.01
Errors = Mapping[Key, TextRow]


@click.command(short_help="A page over several runs.")
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path))
@once("--out", type=click.Path(path_type=Path), default=HISTORY, help="File of the page.")
def history(runs: tuple[Path, ...], out: Path) -> ExitCode:
    """Put RUNS, folders that matrix or gate wrote, oldest first, onto one page.

    It shows the verdicts of each run, with its date and the commit that was checked out, those that changed from one
    run to the next, and errors that made a significant step. Runs with the same seed are on the same noise; compare
    tells more of two of those.
    """
    if len(runs) < 2:
        raise UsageError("history needs two runs or more")
    require_writable_file(out, "--out")
    read = [read_tables(folder) for folder in runs]
    tables = told, changed, steps = history_tables(read)
    sentence = f"{len(runs)} runs, {len(changed.rows)} verdicts changed, {len(steps.rows)} errors made a step"
    write_tables(out, sentence, tables, history=history_series(read))
    cells = [[f"{cell:g}" if isinstance(cell, float) else visible(str(cell)) for cell in row] for row in told.rows]
    lines = (*in_columns([list(told.head), *cells]), sentence, f"the page is {visible(str(out))}")
    print_lines(output(unbroken=True), map(PlainLine, lines))
    return ExitCode.OK


def history_tables(runs: Sequence[SavedTables]) -> list[TablePage]:
    """Return tables of runs in the order they are given: counts, verdicts that changed, steps of errors."""
    verdicts = [name for name in SYMBOLS if name != ABSENT]
    counts = [Counter(row["verdict"] for row in run.verdicts) for run in runs]
    head = ("run", "date", "commit", "version", "seed", *verdicts)
    rows: list[list[str | float | None]] = [
        [*_about(run), *(float(found[name]) for name in verdicts)] for run, found in zip(runs, counts, strict=True)
    ]
    changed = [row for before, after in pairwise(runs) for row in _changes(before, after)]
    steps = [
        (str(before.folder), str(after.folder), *key, one, other, other / one)
        for before, after in pairwise(runs)
        for key, one, other in _steps(before, after)
    ]
    names = ("from", "to", "scheme", "problem", "measure", "quantity")
    level = f"Both errors are at the finest step size; family-wise level {ALPHA:g} for each pair of runs."
    return [
        TablePage("Runs", head, rows),
        TablePage("Changed verdicts", (*names, "before", "after"), changed, _none_words(changed)),
        TablePage("Steps of errors", (*names, "before", "after", "ratio"), steps, (level, *_none_words(steps))),
    ]


def history_series(runs: Sequence[SavedTables]) -> dict[str, Any]:
    """Return what the pictures of a history are drawn from.

    Returns
    -------
    dict
        ``runs``: what each is called; ``counts``: by verdict, how many there are in each; ``errors``: of each
        quantity that made a significant step, its errors at the finest step size, and 1 where a step led to it.
    """
    counts = [Counter(row["verdict"] for row in run.verdicts) for run in runs]
    stepped = [{key for key, _, _ in _steps(*pair)} for pair in pairwise(runs)]
    finest = [_finest(run.levels) for run in runs]
    return {
        "runs": [" ".join(filter(None, _about(run)[:3])) for run in runs],
        "counts": {
            name: [found[name] for found in counts] for name in SYMBOLS if any(name in found for found in counts)
        },
        "errors": [
            {
                "name": "{} on {}, {} {}".format(*key),
                "values": [rounded(number(errors.get(key, {}), "estimate")) for errors in finest],
                "steps": [0, *(int(key in found) for found in stepped)],
            }
            for key in sorted({key for found in stepped for key in found})
        ],
    }


def _about(run: SavedTables) -> list[str]:
    about = [str(run.run.get(name, "")) for name in ("date", "commit")]
    return [str(run.folder), *about, _version(run), str(run.run.get("seed", ""))]


def _none_words(rows: Sequence[object]) -> tuple[str, ...]:
    return () if rows else ("None.",)


def _version(run: SavedTables) -> str:
    versions = run.run.get("versions", {})
    return str(versions.get("sdaeverify", "")) if isinstance(versions, dict) else ""


def _changes(before: SavedTables, after: SavedTables) -> Iterator[tuple[str, ...]]:
    known = {key_of(row): row["verdict"] for row in before.verdicts}
    for row in after.verdicts:
        if known.get(key_of(row), row["verdict"]) != row["verdict"]:
            yield (str(before.folder), str(after.folder), *key_of(row), known[key_of(row)], row["verdict"])


def _steps(before: SavedTables, after: SavedTables) -> Iterator[tuple[Key, float, float]]:
    """Yield the errors at the finest step size that differ by more than chance explains, before and after."""
    old, new = _finest(before.levels), _finest(after.levels)
    common = [key for key in new if key in old and number(old[key], "h") == number(new[key], "h")]
    bound = NormalDist().inv_cdf(1.0 - 0.5 * ALPHA / max(1, len(common)))
    for key in common:
        one, other = (number(errors[key], "estimate") for errors in (old, new))
        spread = hypot(*(number(errors[key], "std_error") for errors in (old, new)))
        if spread > 0.0 and abs(other - one) > bound * spread:
            yield key, one, other


def _finest(levels: Sequence[TextRow]) -> Errors:
    found: dict[Key, TextRow] = {}
    for row in levels:
        if row.get("steps") and not isnan(number(row, "estimate")):
            key = key_of(row)
            if key not in found or number(row, "h") < number(found[key], "h"):
                found[key] = row
    return found
