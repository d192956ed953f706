"""The numbers of a page: the tables of a run as JSON, each text once, each number with six digits."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from math import isnan
from typing import Any

from ..folders import NAMES, Key, SavedTables, TextRow, key_of
from ..reading import Reading, number, read_row
from ..sentences import counts_in_words

ABSENT = "not_applicable"
SCHEMA = 1
# Columns of a level beside h, estimate and standard error, under the name that the page has for them.
LEVEL = {
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
COST = "mean_"
# Columns that begin in the same way and are no cost of a step.
NO_COST = {"mean_std_error"}
# Texts of a finding that are shown as the table has them, and those that are read from it.
SHOWN = (*NAMES, "method", "view", "claim_source", "class", "windows", "reproduce", "heavy_tails")
READ = ("claim", "verdict", "decided_by", "guarded_by", "reason", "no_order", "value_of")
INTERVAL = ("value", "low", "high")


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
        ``texts``: all texts; ``findings``: columns of equal length, texts by number; ``levels``: for each finding a
        mapping of columns; ``absent``: scheme, problem, measure and reason of cells that do not apply, by number.
    """
    texts = _Texts()
    told = [row for row in tables.verdicts if row["verdict"] != ABSENT]
    readings = [read_row(row) for row in told]
    levels = _by_key(tables.levels)
    return {
        "schema": SCHEMA,
        "sentence": counts_in_words(row["verdict"] for row in tables.verdicts),
        "run": _run(tables.run),
        "findings": _findings(told, readings, texts),
        "levels": [_columns(levels.get(key_of(row), ()), texts) for row in told],
        "costs": _costs(tables.levels, texts),
        "absent": _absent(tables.verdicts, texts),
        "passports": dict(passports or {}),
        "texts": list(texts.known),
    }


def rounded(value: float) -> float | str | None:
    """Return a number for JSON: six digits, infinities as texts, nothing for NaN."""
    if isnan(value):
        return None
    short = float(f"{value:.6g}")
    if short in {float("inf"), float("-inf")}:
        return "inf" if short > 0 else "-inf"
    return int(short) if short == int(short) and abs(short) < 1e15 else short


def _run(run: Mapping[str, Any]) -> dict[str, Any]:
    names = ("versions", "platform", "arguments", "seed", "stream_fingerprint", "settings", "warnings", "plugins")
    return {**{name: run[name] for name in names if name in run}, "earlier": len(run.get("earlier", ()))}


def _findings(rows: Sequence[TextRow], readings: Sequence[Reading], texts: _Texts) -> dict[str, list[Any]]:
    words = [_words(row, reading) for row, reading in zip(rows, readings, strict=True)]
    numbers = [_numbers(row, reading) for row, reading in zip(rows, readings, strict=True)]
    return {
        **{name: [texts(told[name]) for told in words] for name in (words[0] if words else ())},
        **{name: [rounded(told[name]) for told in numbers] for name in (numbers[0] if numbers else ())},
    }


def _words(row: TextRow, reading: Reading) -> dict[str, str]:
    return {
        **{name: row.get(name, "") for name in SHOWN},
        **{name: str(getattr(reading, name)) for name in READ},
    }


def _numbers(row: TextRow, reading: Reading) -> dict[str, float]:
    return {
        "margin": reading.margin,
        "local_order": reading.local_order,
        **{f"path_{name}": getattr(reading.path, name) for name in INTERVAL},
        **{f"value_{name}": getattr(reading.value, name) for name in INTERVAL},
        **{name: number(row, name) for name in ("paths", "seconds", "growth_rate", "growth")},
    }


def _by_key(rows: Iterable[TextRow]) -> Mapping[Key, list[TextRow]]:
    grouped: dict[Key, list[TextRow]] = defaultdict(list)
    for row in rows:
        grouped[key_of(row)].append(row)
    return grouped


def _columns(rows: Sequence[TextRow], texts: _Texts) -> dict[str, list[Any]]:
    if not rows:
        return {}
    named = {"h": "h", "estimate": "e", "std_error": "s", **LEVEL}
    present = {name: short for name, short in named.items() if any(row.get(name) for row in rows)}
    columns = {short: [_level(row, name, texts) for row in rows] for name, short in present.items()}
    return {name: column for name, column in columns.items() if name in "hesf" or any(column)}


def _level(row: TextRow, name: str, texts: _Texts) -> Any:
    if name == "functional":
        return texts(row[name])
    if row[name] in {"True", "False"}:
        return int(row[name] == "True")
    return rounded(number(row, name))


def _costs(rows: Iterable[TextRow], texts: _Texts) -> list[list[Any]]:
    """Return scheme, problem, kind and mean at the finest step size of what steps took."""
    finest: dict[tuple[str, str], TextRow] = {}
    for row in rows:
        place = row["scheme"], row["problem"]
        if row.get("steps") and (place not in finest or number(row, "steps") >= number(finest[place], "steps")):
            finest[place] = row
    return [
        [texts(scheme), texts(problem), texts(name.removeprefix(COST).replace("_", " ")), rounded(number(row, name))]
        for (scheme, problem), row in finest.items()
        for name in row
        if name.startswith(COST) and name not in NO_COST and row[name]
    ]


def _absent(rows: Iterable[TextRow], texts: _Texts) -> list[int]:
    """Return scheme, problem, measure and reason of what does not apply, four numbers each, all in a row."""
    absent = [row for row in rows if row["verdict"] == ABSENT]
    return [texts(row[name]) for row in absent for name in ("scheme", "problem", "measure", "reason")]
