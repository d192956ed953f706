"""Data of the page: table columns for JSON, with each text stored once and numbers to six digits."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import isinf, isnan
from typing import Any

from ..cells import TEXT, grouped, number, parse, text
from ..class_words import hint, why
from ..folders import SavedTables, TextRow, key_of
from ..pictures import known_order, reach
from ..saved import settings_of
from ..sentences import counts_of
from ..tables.absent import group_absent
from ..tables.choice import ALONG_PATHS, choices, curves
from ..tables.columns import CLASS_COLUMNS, MEAN
from ..tables.command import commands_of, orders_command
from ..verdict_row import LABELLED, VERDICTS, Interval, VerdictRow

# Columns of a level: always present, present unless 0 throughout, and the column of texts.
LEVEL = ("h", "estimate", "std_error", "fitted")
MARKED = ("steps", "failed_paths", "failed", "truncated_share", "eps", "worst_eps")
FUNCTIONAL = "functional"
TRUTHS = {"True": 1, "False": 0}
# Columns with the prefix of costs that are not costs of a step.
NO_COST = {"mean_std_error"}
SHOWN = [column for column in VERDICTS if column.on_page]
# Texts and numbers of a finding, from the table of verdicts and from the details of its measure.
TEXTS = [column.name for column in SHOWN if column.kind == TEXT]
NUMBERS = [column.name for column in SHOWN if column.kind != TEXT]
DETAILS = ("method", "claim_source", "class", "windows", "heavy_tails")
MEASURED = ("seconds", "step_seconds", "growth_rate", "growth", "order_L_half", "order_L2", "order_L4")
# Columns of the cells that do not apply that are lists.
LISTS = ("problems", "measures")
RUN = ("versions", "platform", "arguments", "seed", "stream_fingerprint", "settings", "warnings", "plugins")


def payload(tables: SavedTables, passports: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the data from which the page of a run is drawn.

    Parameters
    ----------
    tables : SavedTables
    passports : mapping, optional
        Passports of schemes, problems and measures, as returned by `report.passports.passports`.

    Returns
    -------
    dict
        ``findings`` and ``absent``: columns of equal length, of numbers or of indices into ``words``; ``levels``: for
        each finding a mapping of columns; ``costs``, ``densities``: records.
    """
    rows, levels = [VerdictRow.from_row(row) for row in tables.verdicts], grouped(tables.levels, key_of)
    return {
        "sentence": counts_of(rows, tables.absent),
        "run": {name: tables.run[name] for name in RUN if name in tables.run},
        "findings": {**_findings(rows, tables), **_drawn(rows)},
        "levels": [_level_columns(levels.get(key_of(row), ())) for row in tables.verdicts],
        "classes": _classes(tables),
        "costs": list(_costs(tables.levels)),
        "densities": list(_densities(tables.levels)),
        "absent": _absent(tables.absent),
        "choices": list(_choices(rows, tables)),
        "passports": dict(passports or {}),
        "reach": reach(settings_of(tables.run).confidence),
        "labels": [[column.name, column.label] for column in LABELLED],
    }


def _choices(rows: Sequence[VerdictRow], tables: SavedTables) -> Iterator[dict[str, Any]]:
    """Yield the work of each scheme on a problem, for the first quantity of each measure of errors."""
    noise = tables.run.get("noise", {})
    by_problem = grouped(curves(rows, tables.levels, tables.details), lambda each: each.row.problem)
    for problem, found in by_problem.items():
        shown = (each.row.measure for each in found if each.points and each.row.measure in ALONG_PATHS)
        yield from (choices(found, problem, (measure, ""), noise).record for measure in dict.fromkeys(shown))


def to_json(value: float) -> float | str | None:
    """Convert a number for JSON: six digits, infinities as texts, NaN as None."""
    if isnan(value):
        return None
    short = float(f"{value:.6g}")
    if isinf(short):
        return "inf" if short > 0 else "-inf"
    return int(short) if short.is_integer() and abs(short) < 1e15 else short


def _findings(rows: Sequence[VerdictRow], tables: SavedTables) -> dict[str, Any]:
    known = {key_of(row): row for row in tables.details}
    cells, details = [row.cells for row in rows], [known.get(key_of(row), {}) for row in tables.verdicts]
    commands = [{"reproduce": command} for command in commands_of(cells, tables.run)]
    return {
        **_texts(cells, TEXTS),
        **_numbers(cells, NUMBERS),
        **_texts(details, DETAILS),
        **_numbers(details, MEASURED),
        **_texts(commands, ("reproduce",)),
        **_texts([{"conditions": _hint(row, tables)} for row in rows], ("conditions",)),
    }


def _hint(row: VerdictRow, tables: SavedTables) -> str:
    return hint(tables.classes, row.scheme, row.measure, row.verdict)


def _classes(tables: SavedTables) -> dict[str, Any]:
    """Return the columns of the table of classes, with the command that reproduces a row and its style."""
    plugins, unnamed = tables.run.get("files", ()), {*tables.run.get("unnamed", ())}
    told = [
        {
            **row,
            "claim": row["claimed_order"],
            "reason": why(row) if row["verdict"] == "refuted" else "",
            "reproduce": "" if row["scheme"] in unnamed else _command(row, plugins),
        }
        for row in tables.classes
    ]
    texts = [column.name for column in CLASS_COLUMNS if column.kind == TEXT]
    numbers = [column.name for column in CLASS_COLUMNS if column.kind != TEXT]
    return {**_texts(told, [*texts, "reproduce", "reason"]), **_numbers(told, numbers)}


def _command(row: TextRow, plugins: Sequence[str]) -> str:
    motions = number(row, "motions")
    return orders_command(row["scheme"], row["class"], 1 if isnan(motions) else int(motions), plugins)


def _drawn(rows: Sequence[VerdictRow]) -> dict[str, list[Any]]:
    """Return the columns needed for pictures: accepted orders, and known orders with their intervals."""
    orders = [known_order(row) for row in rows]
    return {
        "least": [to_json(row.claimed_order - row.margin) for row in rows],
        "sampled": [int(sampled) for _, sampled in orders],
        **{f"order_{end}": [to_json(getattr(order, end)) for order, _ in orders] for end in Interval._fields},
    }


def _texts(rows: Iterable[Mapping[str, object]], names: Iterable[str]) -> dict[str, Any]:
    told = list(rows)
    return {name: factorise([text(row, name) for row in told]) for name in names}


def _absent(rows: Iterable[TextRow]) -> dict[str, Any]:
    """Return the columns of the groups of cells that do not apply; a cell of problems or measures is a list."""
    groups = group_absent(rows)
    texts = _texts([group.row for group in groups], ("scheme", "quantity", "reason"))
    return {**texts, **{name: _factorise_lists([getattr(group, name) for group in groups]) for name in LISTS}}


def _factorise_lists(cells: Sequence[Sequence[str]]) -> dict[str, list[Any]]:
    places = {word: place for place, word in enumerate(dict.fromkeys(chain(*cells)))}
    return {"words": list(places), "at": [[places[word] for word in cell] for cell in cells]}


def factorise(cells: Sequence[str]) -> dict[str, list[Any]]:
    """Return a column of texts that stores each distinct text once: the texts, and the index of that of each row."""
    places = {word: place for place, word in enumerate(dict.fromkeys(cells))}
    return {"words": list(places), "at": [places[cell] for cell in cells]}


def _numbers(rows: Sequence[Mapping[str, object]], names: Iterable[str]) -> dict[str, list[Any]]:
    return {name: [_read_cell(str(row.get(name, ""))) for row in rows] for name in names}


def _read_cell(told: str) -> float | str | None:
    return TRUTHS[told] if told in TRUTHS else to_json(parse(told))


def _level_columns(rows: Sequence[TextRow]) -> dict[str, list[Any]]:
    columns = {
        name: cells for name, cells in _numbers(rows, (*LEVEL, *MARKED)).items() if name in LEVEL or any(cells)
    }
    told = {name: cells for name, cells in columns.items() if {*cells} != {None}}
    words = [row.get(FUNCTIONAL, "") for row in rows]
    return {**told, **({FUNCTIONAL: words} if any(words) else {})}


def _densities(rows: Iterable[TextRow]) -> Iterator[dict[str, Any]]:
    """Yield each density: evaluation points, estimate and exact value."""
    found = grouped((row for row in rows if row.get("at")), key_of)
    for (scheme, problem, _, quantity), points in found.items():
        columns = _numbers(points, ("at", "estimate", "exact"))
        h = to_json(number(points[0], "h"))
        yield {"scheme": scheme, "problem": problem, "quantity": quantity, "h": h, **columns}


def _costs(rows: Iterable[TextRow]) -> Iterator[dict[str, Any]]:
    """Yield the mean of each cost of a step at the finest step size."""
    cells = grouped((row for row in rows if row.get("steps")), lambda row: (row["scheme"], row["problem"]))
    for (scheme, problem), found in cells.items():
        finest = max(reversed(found), key=lambda row: parse(row["steps"]))
        for name in finest:
            if name.startswith(MEAN) and name not in NO_COST and finest[name]:
                kind = name.removeprefix(MEAN).replace("_", " ")
                yield {"scheme": scheme, "problem": problem, "kind": kind, "mean": _read_cell(finest[name])}
