"""``history``: runs in a row, their verdicts, what changed between them, errors that made a significant step."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import hypot, isfinite, isnan
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple

import click

from ...errors import UsageError
from ...report.cells import number
from ...report.files import require_writable_file
from ...report.folders import Key, SavedTables, TextRow, key_of, read_tables
from ...report.html import TablePage, to_json, write_tables
from ...report.plain import visible, wrap_text
from ...report.sentences import ABSENT, SYMBOLS, PlainLine, counts_in_words
from ...report.verdict_row import ORDER, Interval, VerdictRow
from ..console import output, print_lines
from ..exit_codes import ExitCode
from ..options import PLACE, once

HISTORY = Path("reports", "history.html")
# Of any step that is marked though nothing has changed, over all of a kind that are compared.
ALPHA = 0.01
# What is not sampled has made a step where it has changed by more: an order by so much, a constant by such a part.
UNSAMPLED = 0.01
# What the orders of these measures are called; and what a constant belongs to.
LETTERS = {"strong": "p", "weak": "q"}
HALF = 0.5
# In the terminal: verdicts that changed, characters of a date up to its minutes, and of a commit.
SHOWN, MINUTES, COMMIT = 10, 16, 10


class RunNumber(NamedTuple):
    """A number with its standard error, 0 where nothing is sampled, and the step size that it is told at, if any."""

    value: float
    spread: float = 0.0
    h: float = 0.0


Numbers = Mapping[Key, RunNumber]


@click.command(short_help="A page over several runs.")
@click.argument("runs", nargs=-1, required=True, type=PLACE)
@once("--out", type=PLACE, default=HISTORY, help="File of the page.")
def history(runs: tuple[Path, ...], out: Path) -> ExitCode:
    """Put RUNS, folders that matrix or gate wrote, oldest first, onto one page.

    It shows the verdicts of each run, with its date and the commit that was checked out, those that changed from one
    run to the next, and orders and constants of errors with the significant steps they made. Runs with the same seed
    are on the same noise; compare tells more of two of those.
    """
    if len(runs) < 2:
        raise UsageError("history needs two runs or more")
    require_writable_file(out, "--out")
    read = [read_tables(folder) for folder in runs]
    tables = _, changed, orders, constants = history_tables(read)
    steps = f"{len(orders.rows)} orders and {len(constants.rows)} error constants made a step"
    sentence = f"{len(runs)} runs, {len(changed.rows)} verdicts changed, {steps}"
    write_tables(out, sentence, tables, history=history_series(read))
    texts = [*map(_run_in_words, read), *map(_change_in_words, changed.rows[:SHOWN]), sentence, f"the page is {out}"]
    console = output()
    print_lines(
        console, (PlainLine(line) for text in texts for line in wrap_text(visible(text), console.width, "  "))
    )
    return ExitCode.OK


def _run_in_words(run: SavedTables) -> str:
    folder, date, commit, *_ = _about(run)
    when = ", ".join(filter(None, (date[:MINUTES].replace("T", " "), commit[:COMMIT])))
    return f"{folder} ({when}): {counts_in_words(row['verdict'] for row in run.verdicts)}"


def _change_in_words(row: Sequence[object]) -> str:
    earlier, later, scheme, problem, measure, quantity, before, after = row
    return f"{scheme} on {problem}, {measure} {quantity}: {before} in {earlier}, {after} in {later}"


def history_tables(runs: Sequence[SavedTables]) -> list[TablePage]:
    """Return tables of runs in the order they are given: counts, verdicts that changed, steps of errors."""
    verdicts = [name for name in SYMBOLS if name != ABSENT]
    counts = [Counter(row["verdict"] for row in run.verdicts) for run in runs]
    head = ("run", "date", "commit", "version", "seed", *verdicts)
    rows: list[list[str | float | None]] = [
        [*_about(run), *(float(found[name]) for name in verdicts)] for run, found in zip(runs, counts, strict=True)
    ]
    changed = [row for before, after in pairwise(runs) for row in _changes(before, after)]
    names = ("from", "to", "scheme", "problem", "measure", "quantity")
    level = f"Family-wise level {ALPHA:g} for each pair of runs; what is not sampled has changed by {UNSAMPLED:g}."
    orders, constants = (_step_rows(runs, [numbers(run) for run in runs]) for numbers in (_orders, _constants))
    return [
        TablePage("Runs", head, rows),
        TablePage("Changed verdicts", (*names, "before", "after"), changed, _none_words(changed)),
        TablePage("Steps of orders", (*names, "before", "after", "ratio"), orders, (level, *_none_words(orders))),
        TablePage(
            "Steps of error constants",
            (*names, "before", "after", "ratio"),
            constants,
            ("C of C h^p at the finest step size, p as claimed.", level, *_none_words(constants)),
        ),
    ]


def history_series(runs: Sequence[SavedTables]) -> dict[str, Any]:
    """Return what the pictures of a history are drawn from.

    Returns
    -------
    dict
        ``runs``: what each is called; ``counts``: by verdict, how many there are in each; ``orders``, ``constants``:
        of each quantity what it is of and called, its values run by run, and 1 where a significant step led to it.
    """
    counts = [Counter(row["verdict"] for row in run.verdicts) for run in runs]
    return {
        "runs": [" ".join(filter(None, _about(run)[:3])) for run in runs],
        "counts": {
            name: [found[name] for found in counts] for name in SYMBOLS if any(name in found for found in counts)
        },
        "orders": _series([_orders(run) for run in runs]),
        "constants": _series([_constants(run) for run in runs]),
    }


def _series(runs: Sequence[Numbers]) -> list[dict[str, Any]]:
    stepped = [{key for key, _, _ in _steps(*pair)} for pair in pairwise(runs)]
    return [
        {
            "cell": f"{key[0]} on {key[1]}",
            "measure": f"{key[2]}, {LETTERS[key[2]]}" if key[2] in LETTERS else key[2],
            "quantity": key[3],
            "values": [to_json(known[key].value) if key in known else None for known in runs],
            "steps": [0, *(int(key in found) for found in stepped)],
        }
        for key in sorted({key for known in runs for key in known})
    ]


def _step_rows(runs: Sequence[SavedTables], numbers: Sequence[Numbers]) -> list[tuple[str | float | None, ...]]:
    pairs = zip(pairwise(runs), pairwise(numbers), strict=True)
    return [
        (str(before.folder), str(after.folder), *key, one, other, other / one if one else None)
        for (before, after), pair in pairs
        for key, one, other in _steps(*pair)
    ]


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


def _steps(before: Numbers, after: Numbers) -> Iterator[tuple[Key, float, float]]:
    """Yield what differs by more than chance explains, before and after."""
    common = [key for key in after if key in before and after[key].h == before[key].h]
    bound = NormalDist().inv_cdf(1.0 - 0.5 * ALPHA / max(1, len(common)))
    for key in common:
        (one, old, _), (other, new, _) = before[key], after[key]
        spread = hypot(old, new)
        size = abs(one) if after[key].h else 1.0
        if abs(other - one) > (bound * spread if spread > 0.0 else UNSAMPLED * size):
            yield key, one, other


def _orders(run: SavedTables) -> Numbers:
    """Return the order of each quantity: along paths, else by moments, else of one step."""
    reach = NormalDist().inv_cdf(0.5 * (1.0 + _confidence(run)))
    found = {}
    for row in run.verdicts:
        told = VerdictRow.from_row(row)
        known = told.path if told.path.known else told.estimate if ORDER in told.value_of else Interval()
        spread = 0.5 * (known.high - known.low) / reach
        value = known.value if known.known else told.local_order
        if isfinite(value):
            found[key_of(row)] = RunNumber(value, spread if isfinite(spread) else 0.0)
    return found


def _constants(run: SavedTables) -> Numbers:
    """Return C of |e(h)| = C h^p for each quantity at the finest step size, p as claimed, else to the next half."""
    powers = {}
    for row in run.verdicts:
        told = VerdictRow.from_row(row)
        claim, found = told.claimed_order, told.path_order
        powers[key_of(row)] = claim if isfinite(claim) else HALF * round(found / HALF) if isfinite(found) else 0.0
    return {
        key: RunNumber(abs(number(row, "estimate")) / scale, number(row, "std_error") / scale, number(row, "h"))
        for key, row in _finest(run.levels).items()
        if key in powers and (scale := number(row, "h") ** powers[key]) > 0.0
    }


def _confidence(run: SavedTables) -> float:
    settings = run.run.get("settings", {})
    found = settings.get("confidence") if isinstance(settings, dict) else None
    return found if isinstance(found, float) and HALF <= found < 1.0 else 0.99


def _finest(levels: Sequence[TextRow]) -> Mapping[Key, TextRow]:
    found: dict[Key, TextRow] = {}
    for row in levels:
        if not row.get("at") and not isnan(number(row, "estimate")):
            key = key_of(row)
            if key not in found or number(row, "h") < number(found[key], "h"):
                found[key] = row
    return found
