"""Several runs in a row: their verdicts, what changed between them, and errors that made a significant step."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import hypot, isnan
from statistics import NormalDist

from ..report.folders import Key, SavedTables, TextRow, key_of
from ..report.html import TablePage
from ..report.reading import number
from ..report.sentences import ABSENT, SYMBOLS

# Of any step that is marked though nothing has changed, over all that are compared.
ALPHA = 0.01
Errors = Mapping[Key, TextRow]


def history(runs: Sequence[SavedTables]) -> list[TablePage]:
    """Return tables of runs in the order they are given: counts, verdicts that changed, steps of errors."""
    verdicts = [name for name in SYMBOLS if name != ABSENT]
    counts = [Counter(row["verdict"] for row in run.verdicts) for run in runs]
    head = ("run", "version", "seed", *verdicts)
    rows: list[list[str | float | None]] = [
        [str(run.folder), _version(run), str(run.run.get("seed", "")), *(float(found[name]) for name in verdicts)]
        for run, found in zip(runs, counts, strict=True)
    ]
    changed = [row for before, after in pairwise(runs) for row in _changes(before, after)]
    steps = [row for before, after in pairwise(runs) for row in _steps(before, after)]
    names = ("from", "to", "scheme", "problem", "measure", "quantity")
    level = f"Both errors are at the finest step size; family-wise level {ALPHA:g} for each pair of runs."
    return [
        TablePage("Runs", head, rows),
        TablePage("Changed verdicts", (*names, "before", "after"), changed, _nothing(changed)),
        TablePage("Steps of errors", (*names, "before", "after", "ratio"), steps, (level, *_nothing(steps))),
    ]


def _nothing(rows: Sequence[object]) -> tuple[str, ...]:
    return () if rows else ("None.",)


def _version(run: SavedTables) -> str:
    versions = run.run.get("versions", {})
    return str(versions.get("sdaeverify", "")) if isinstance(versions, dict) else ""


def _changes(before: SavedTables, after: SavedTables) -> Iterator[tuple[str, ...]]:
    known = {key_of(row): row["verdict"] for row in before.verdicts}
    for row in after.verdicts:
        if known.get(key_of(row), row["verdict"]) != row["verdict"]:
            yield (str(before.folder), str(after.folder), *key_of(row), known[key_of(row)], row["verdict"])


def _steps(before: SavedTables, after: SavedTables) -> Iterator[tuple[str | float, ...]]:
    """Yield the errors at the finest step size that differ by more than chance explains."""
    old, new = _finest(before.levels), _finest(after.levels)
    common = [key for key in new if key in old and number(old[key], "h") == number(new[key], "h")]
    bound = NormalDist().inv_cdf(1.0 - 0.5 * ALPHA / max(1, len(common)))
    for key in common:
        one, other = (number(errors[key], "estimate") for errors in (old, new))
        spread = hypot(*(number(errors[key], "std_error") for errors in (old, new)))
        if spread > 0.0 and abs(other - one) > bound * spread:
            yield str(before.folder), str(after.folder), *key, one, other, other / one


def _finest(levels: Sequence[TextRow]) -> Errors:
    found: dict[Key, TextRow] = {}
    for row in levels:
        if row.get("steps") and not isnan(number(row, "estimate")):
            key = key_of(row)
            if key not in found or number(row, "h") < number(found[key], "h"):
                found[key] = row
    return found
