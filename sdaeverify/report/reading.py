"""A row of the verdicts as people are told of it."""

from collections.abc import Mapping
from math import isfinite, isnan, nan
from typing import Any, NamedTuple

from .tables.columns import VERDICTS, names

ORDER, BIAS, RESIDUAL, AT_END = "order", "bias", "largest residual", "weak order at T by moments"
# Of verdicts that something decides.
DECIDED = {"verified", "refuted"}
NUMBERS = {column.name for column in VERDICTS if column.kind != "text"}

Row = Mapping[str, object]


class Interval(NamedTuple):
    """An estimate with its interval at the run's confidence; NaN where there is none."""

    value: float = nan
    low: float = nan
    high: float = nan

    @property
    def known(self) -> bool:
        """Whether there is an estimate."""
        return not isnan(self.value)


class Reading(NamedTuple):
    """What a row of the verdicts says; its columns, see `tables.columns`, estimates with their intervals."""

    claim: str
    margin: float
    local_order: float
    path: Interval
    value: Interval
    value_of: str
    verdict: str
    decided_by: str
    guarded_by: str
    reason: str
    reason_kind: str

    @property
    def row(self) -> dict[str, object]:
        """The columns."""
        intervals = {
            "path_order": self.path.value,
            "path_low": self.path.low,
            "path_high": self.path.high,
            "value": self.value.value,
            "value_low": self.value.low,
            "value_high": self.value.high,
        }
        return {**{name: value for name, value in self._asdict().items() if name != "path"}, **intervals}


def read_row(row: Row) -> Reading:
    """Read a row of the verdicts, as a table holds it or as text."""
    return Reading(
        claim=text(row, "claim"),
        margin=number(row, "margin"),
        local_order=number(row, "local_order"),
        path=Interval(*(number(row, name) for name in ("path_order", "path_low", "path_high"))),
        value=Interval(*(number(row, name) for name in ("value", "value_low", "value_high"))),
        **{
            name: text(row, name)
            for name in ("value_of", "verdict", "decided_by", "guarded_by", "reason", "reason_kind")
        },
    )


def record(row: Row) -> dict[str, Any]:
    """Return a row of the verdicts as a record for JSON, which knows neither infinity nor NaN."""
    return {
        name: _number(number(row, name)) if name in NUMBERS else text(row, name) or None for name in names(VERDICTS)
    }


def text(row: Row, name: str) -> str:
    """Return a text of a row; empty where it has none."""
    found = row.get(name)
    told = "" if found is None else str(found)
    return "" if told == "nan" else told


def number(row: Row, name: str) -> float:
    """Return a number of a row; NaN where it has none."""
    return parse(text(row, name))


def parse(told: str) -> float:
    """Return a number; NaN where a text is none."""
    try:
        return float(told or nan)
    except ValueError:
        return nan


def claimed_order(claim: str) -> float:
    """Return the order that a claim names; NaN where it names none."""
    head, _, value = claim.partition(">= ")
    return float(value) if head.strip() == ORDER else nan


def _number(value: float) -> float | str | None:
    if isnan(value):
        return None
    return value if isfinite(value) else str(value)
