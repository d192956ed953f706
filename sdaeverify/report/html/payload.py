"""The numbers of a page: the tables of a run as JSON, each text once, each number with six digits."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from math import isinf, isnan
from typing import Any

from ..cells import TEXT, parse
from ..folders import Key, SavedTables, TextRow, key_of
from ..pictures import known_order, reach
from ..saved import settings_of
from ..sentences import ABSENT, counts_in_words
from ..tables.columns import MEAN
from ..tables.command import CELL, commands_of
from ..verdict_row import LABELLED, VERDICTS, VerdictRow

SCHEMA = 2
# Columns of a level, under the name that the page has for them.
LEVEL = {
    "h": "h",
    "estimate": "e",
    "std_error": "s",
    "steps": "n",
    "paths": "m",
    "local_order": "p",
    "fitted": "f",
    "failed_paths": "x",
    "truncated_share": "t",
    "error_floor": "r",
    "low": "lo",
    "high": "hi",
    "ci_low": "lo",
    "ci_high": "hi",
    "functional": "u",
    "eps": "eps",
    "worst_eps": "eps",
    "failed": "x",
    "most": "most",
}
TRUTHS = {"True": 1, "False": 0}
WORDS = {"functional"}
# Columns that begin in the same way and are no cost of a step.
NO_COST = {"mean_std_error"}
SHOWN = [column for column in VERDICTS if column.on_page]
# Texts and numbers of a finding, from the verdicts and from the details of its measure.
TEXTS = [column.name for column in SHOWN if column.kind == TEXT]
NUMBERS = [column.name for column in SHOWN if column.kind != TEXT]
DETAILS = ("method", "claim_source", "class", "windows", "heavy_tails")
MEASURED = ("seconds", "step_seconds", "growth_rate", "growth", "order_L1/2", "order_L2", "order_L4")


ORDERS = ("order_value", "order_low", "order_high")


class _Texts:
    """Numbers of texts, each text kept once."""

    def __init__(self) -> None:
        self.known: dict[str, int] = {}

    def __call__(self, text: str) -> int:
        return self.known.setdefault(text, len(self.known))


def payload(tables: SavedTables, passports: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return what the page of a run is drawn from.

    Parameters
    ----------
    tables : SavedTables
    passports : mapping, optional
        Of schemes, problems and measures, as `report.passports.passports` returns them.

    Returns
    -------
    dict
        ``texts``: all texts; ``findings``: columns of equal length; ``text_columns``: those that hold texts, by
        number; ``levels``: for each finding a mapping of columns; ``absent``: scheme, problem, measure and reason of
        cells that do not apply, by number.
    """
    texts = _Texts()
    told, levels = tables.verdicts, _by_key(tables.levels)
    return {
        "schema": SCHEMA,
        "sentence": counts_in_words([*(row["verdict"] for row in told), *(ABSENT for _ in tables.absent)]),
        "run": _run(tables.run),
        "findings": _findings(tables, texts),
        "levels": [_columns(levels.get(key_of(row), ()), texts) for row in told],
        "costs": _costs(tables.levels, texts),
        "densities": _densities(tables.levels, texts),
        "absent": _absent(tables.absent, texts),
        "passports": dict(passports or {}),
        "texts": list(texts.known),
        "text_columns": [*TEXTS, *DETAILS, "reproduce"],
        "reach": reach(settings_of(tables.run).confidence),
        "labels": [[column.name, column.label] for column in LABELLED],
    }


def to_json(value: float) -> float | str | None:
    """Return a number for JSON: six digits, infinities as texts, nothing for NaN."""
    if isnan(value):
        return None
    short = float(f"{value:.6g}")
    if isinf(short):
        return "inf" if short > 0 else "-inf"
    return int(short) if short.is_integer() and abs(short) < 1e15 else short


def _run(run: Mapping[str, Any]) -> dict[str, Any]:
    names = ("versions", "platform", "arguments", "seed", "stream_fingerprint", "settings", "warnings", "plugins")
    return {name: run[name] for name in names if name in run}


def _findings(tables: SavedTables, texts: _Texts) -> dict[str, list[Any]]:
    told, details = tables.verdicts, {key_of(row): row for row in tables.details}
    rows, further = [VerdictRow.from_row(row) for row in told], [details.get(key_of(row), {}) for row in told]
    cells = {_cell(row): row for row in told}
    commands = dict(zip(cells, commands_of(cells.values(), tables.run), strict=True))
    return {
        **{name: [texts(getattr(row, name)) for row in rows] for name in TEXTS},
        **{name: [texts(row.get(name, "")) for row in further] for name in DETAILS},
        "reproduce": [texts(commands[_cell(row)]) for row in told],
        **{name: [to_json(getattr(row, name)) for row in rows] for name in NUMBERS},
        **_drawn(rows),
        **{name: [_read_cell(row.get(name, "")) for row in further] for name in MEASURED},
    }


def _drawn(rows: Sequence[VerdictRow]) -> dict[str, list[Any]]:
    """Return the columns of what pictures show of rows."""
    orders = [known_order(row) for row in rows]
    return {
        "least": [to_json(row.claimed_order - row.margin) for row in rows],
        **{end: [to_json(getattr(order, end.removeprefix("order_"))) for order, _ in orders] for end in ORDERS},
        "sampled": [int(sampled) for _, sampled in orders],
    }


def _cell(row: TextRow) -> tuple[str, ...]:
    return tuple(row.get(name, "") for name in CELL)


def _by_key(rows: Iterable[TextRow]) -> Mapping[Key, list[TextRow]]:
    grouped: dict[Key, list[TextRow]] = defaultdict(list)
    for row in rows:
        grouped[key_of(row)].append(row)
    return grouped


def _columns(rows: Sequence[TextRow], texts: _Texts) -> dict[str, list[Any]]:
    # The rows of a table have the same columns.
    told = {name: [row[name] for row in rows] for name in LEVEL if name in rows[0]} if rows else {}
    present = {name: cells for name, cells in told.items() if any(cells)}
    columns = {LEVEL[name]: [*map(texts if name in WORDS else _read_cell, cells)] for name, cells in present.items()}
    return {name: column for name, column in columns.items() if name in "hesf" or any(column)}


@lru_cache(maxsize=2**12)
def _read_cell(text: str) -> float | str | None:
    # Step sizes, numbers of steps and paths, truth values and zeros stand in most rows.
    return TRUTHS[text] if text in TRUTHS else to_json(parse(text))


def _densities(rows: Iterable[TextRow], texts: _Texts) -> list[list[Any]]:
    """Return scheme, problem, quantity and step size of each density, its points, itself and the exact one there."""
    found = _by_key(row for row in rows if row.get("at"))
    columns = ("at", "estimate", "exact")
    return [
        [texts(scheme), texts(problem), texts(quantity), _read_cell(points[0].get("h", "")),
         *([_read_cell(row.get(name, "")) for row in points] for name in columns)]
        for (scheme, problem, _, quantity), points in found.items()
    ]  # fmt: skip


def _costs(rows: Iterable[TextRow], texts: _Texts) -> list[list[Any]]:
    """Return scheme, problem, kind and mean at the finest step size of what steps took."""
    finest: dict[tuple[str, str], TextRow] = {}
    for row in rows:
        place = row["scheme"], row["problem"]
        if row.get("steps") and (place not in finest or parse(row["steps"]) >= parse(finest[place]["steps"])):
            finest[place] = row
    return [
        [texts(scheme), texts(problem), texts(name.removeprefix(MEAN).replace("_", " ")), _read_cell(row[name])]
        for (scheme, problem), row in finest.items()
        for name in row
        if name.startswith(MEAN) and name not in NO_COST and row[name]
    ]


def _absent(rows: Iterable[TextRow], texts: _Texts) -> list[int]:
    """Return scheme, problem, measure and reason of what does not apply, four numbers each, all in a row."""
    return [texts(row[name]) for row in rows for name in ("scheme", "problem", "measure", "reason")]
