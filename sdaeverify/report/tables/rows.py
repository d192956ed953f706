"""Results as rows: one a quantity, one a quantity and step size, and one for what does not apply.

A finding is a row as people are told of it: one meaning a field in every measure, and no order of noise.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from math import inf, isfinite, isnan, nan
from types import NoneType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.finding import Finding, Reason, Verdict
from ...contracts.settings import Settings
from ...simulate.tracks import COST, COUNTED
from ...study import CellResult
from .. import folders
from ..reading import AT_END, BIAS, DECIDED, ORDER, RESIDUAL, Interval, Reading
from .columns import DETAILS, LEVELS, MEAN, NOT_APPLICABLE, VERDICTS, WHOLE, Column, details_file, names

if TYPE_CHECKING:
    import pandas as pd

GUARDED = "guarded by "
INTEGER, REAL = (int, np.integer), (float, np.floating)
# Standard errors from which on a mean difference tells something.
RESOLVED = 3.0
SAMPLED, AT_ONCE, ONE_STEP, CONTRACT = 3, 2, 1, 0


def read_finding(found: Finding, value_of: str = "") -> Reading:
    """Read a finding.

    Parameters
    ----------
    found : Finding
    value_of : str
        What its measure estimates; empty for an order.
    """
    kind, claim = _kind(found, value_of), str(found.claim or "")
    path, why = _along_paths(found) if kind == ORDER else (Interval(), "")
    value, told = _value(found, kind, path)
    reason = found.reason.then(Reason(f"no order along paths: {why}" if why else ""))
    decided = found.method and found.verdict in DECIDED
    return Reading(
        claim=claim,
        margin=found.claim.margin if found.claim and claim.startswith(ORDER) else nan,
        local_order=_local_order(found, kind),
        path=path,
        value=value,
        value_of=told,
        verdict=str(found.verdict),
        decided_by=f"T{found.tier}" if decided or (found.method and found.tier == CONTRACT) else "",
        guarded_by=found.method.partition(GUARDED)[2] if decided else "",
        reason=str(reason),
        reason_kind=", ".join(found.reason.kinds),
    )


def _kind(found: Finding, value_of: str) -> str:
    if found.details.get("class") == BIAS or str(found.claim or "").startswith("unbiased"):
        return BIAS
    if found.method.startswith(RESIDUAL):
        return RESIDUAL
    return value_of or ORDER


def _detail(found: Finding, name: str) -> float:
    return float(str(found.details.get(name, nan)))


def _estimate(found: Finding) -> Interval:
    return Interval(found.estimate, found.low, found.high)


def _along_paths(found: Finding) -> tuple[Interval, str]:
    """Return the order along paths, and why there is none although paths were sampled."""
    told = "informative" in found.details
    sampled = found.method and (found.tier == SAMPLED or GUARDED in found.method)
    order = Interval(*(_detail(found, f"slope{end}") for end in ("", "_low", "_high"))) if told else Interval()
    order = order if told else _estimate(found) if sampled else Interval()
    if not order.known:
        return Interval(), ""
    if told and not found.details["informative"]:
        resolved = _detail(found, "resolved")
        changes = "its errors change sign between levels"
        return Interval(), f"a mean difference is {resolved:.1f} standard errors" if resolved < RESOLVED else changes
    if not (isfinite(order.low) and isfinite(order.high)):
        return Interval(), "its interval is not finite"
    return order, ""


def _local_order(found: Finding, kind: str) -> float:
    known = _detail(found, "local_order")
    alone = isnan(known) and kind == ORDER and found.method and found.tier == ONE_STEP
    return found.estimate if alone else known


def _value(found: Finding, kind: str, path: Interval) -> tuple[Interval, str]:
    if kind != ORDER:
        return (value, kind) if (value := _estimate(found)).known else (Interval(), "")
    if not isnan(moments := _detail(found, "moment_order")):
        return Interval(moments), AT_END
    at_once = found.method and found.tier == AT_ONCE
    value = _estimate(found) if at_once and isnan(_detail(found, "local_order")) and not path.known else Interval()
    # All that is known may be that an order is at least so high.
    told = value if isfinite(value.low) or value.value == inf else Interval()
    return (told, ORDER) if told.known else (Interval(), "")


Record = dict[str, object]


class Rows(NamedTuple):
    """The rows of a run but for its levels.

    Attributes
    ----------
    verdicts, absent : list of dict
        What is claimed or measured, and what does not apply.
    details : dict of str to list of dict
        By measure, further columns of the verdicts.
    """

    verdicts: list[Record]
    absent: list[Record]
    details: dict[str, list[Record]]


def rows_of(results: Iterable[CellResult]) -> Rows:
    """Return the rows of results."""
    rows = Rows([], [], {})
    for result in results:
        for finding in result.findings:
            named = _names(result, finding.quantity)
            if finding.verdict is Verdict.NOT_APPLICABLE:
                rows.absent.append({**named, "reason": str(finding.reason), "run": 0})
                continue
            rows.verdicts.append({**named, **_list_finding(result, finding)})
            rows.details.setdefault(result.cell.measure.name, []).append({**named, **_list_details(result, finding)})
    return rows


class Table(NamedTuple):
    """Columns of equal length.

    Attributes
    ----------
    columns : dict of str to list
        None where a row has no such value.
    whole : frozenset of str
        Columns of whole numbers.
    """

    columns: dict[str, list[object]]
    whole: frozenset[str]

    @property
    def frame(self) -> "pd.DataFrame":
        """The table for pandas."""
        import pandas as pd  # noqa: PLC0415 - whoever asks for files alone need not wait for it

        told = {name: [nan if v is None else v for v in column] for name, column in self.columns.items()}
        whole = (name for name in self.whole if all(v is None or _is_whole(v) for v in self.columns[name]))
        # A column of whole numbers reads the same whether or not other rows leave it empty.
        return pd.DataFrame(told).astype(dict.fromkeys(whole, "Int64"))


def tables_of(rows: Rows) -> dict[str, Table]:
    """Return rows as tables, by the names of their files."""
    found = {folders.VERDICTS: (rows.verdicts, VERDICTS), folders.NOT_APPLICABLE: (rows.absent, NOT_APPLICABLE)}
    found |= {details_file(measure): (told, DETAILS) for measure, told in rows.details.items()}
    return {file: table_of(told, columns) for file, (told, columns) in found.items()}


def level_table(results: Iterable[CellResult], settings: Settings) -> Table:
    """Return one row for each quantity of each cell at each step size.

    Parameters
    ----------
    results : iterable of CellResult
    settings : Settings

    Returns
    -------
    Table
        The columns of all measures first, then those of some.
    """
    return table_of([row for result in results for row in _level_rows(result, settings)], LEVELS)


def table_of(rows: Sequence[Mapping[str, object]], columns: Sequence[Column] = ()) -> Table:
    """Return rows as a table: the columns that are known first, then whatever else the rows have."""
    known = names(columns)
    every = dict.fromkeys(chain(known, *rows))
    whole = {column.name for column in columns if column.kind == WHOLE} | (every.keys() - {*known})
    told: dict[str, list[object]] = {name: [None] * len(rows) for name in every}
    for place, row in enumerate(rows):
        for name, value in row.items():
            told[name][place] = value
    return Table({name: _column(values, whole=name in whole) for name, values in told.items()}, frozenset(whole))


def _column(values: list[Any], *, whole: bool) -> list[object]:
    """Return numbers of one kind: whole ones become floats where others are not whole, or where some are missing."""
    kinds = {*map(type, values)}
    integers = {kind for kind in kinds if issubclass(kind, INTEGER)}
    others = kinds - integers
    if not integers or not others or (whole and integers == {int} and others == {NoneType}):
        return values
    if bool in kinds or not all(issubclass(kind, (*REAL, NoneType)) for kind in others):
        return values
    return [None if value is None else float(value) for value in values]


def _is_whole(value: object) -> bool:
    # Evidence from elsewhere may count to any number.
    return type(value) is int and abs(value) < 2**63


def _names(result: CellResult, quantity: str) -> Record:
    cell = result.cell
    return {
        "scheme": cell.scheme.label,
        "problem": cell.spec.label,
        "measure": cell.measure.name,
        "quantity": quantity,
    }


def _list_finding(result: CellResult, finding: Finding) -> Record:
    return {
        "view": result.cell.view,
        **read_finding(finding, result.cell.measure.value_of).row,
        "p_verified": finding.p_verified,
        "p_refuted": finding.p_refuted,
        "paths": result.paths,
        "run": 0,
    }


def _list_details(result: CellResult, finding: Finding) -> Record:
    return {
        "method": finding.method,
        "claim_source": finding.claim.source if finding.claim else "",
        "seconds": round(result.seconds, 3),
        "step_seconds": float(f"{result.step_seconds:.3g}"),
        **{name: value for name, value in finding.details.items() if name not in IN_VERDICTS},
    }


IN_VERDICTS = {"local_order"}


def _level_rows(result: CellResult, settings: Settings) -> Iterator[dict[str, Any]]:
    # Its quantities share what is told of the steps of a level.
    levels = {row.level for row in result.levels if row.level is not None}
    steps = {level: _of_level(result, settings, level) for level in levels}
    for row in result.levels:
        yield {
            **_names(result, row.quantity),
            "h": row.h,
            "estimate": row.estimate,
            "std_error": row.std_error,
            **({} if row.level is None else steps[row.level]),
            **row.details,
        }


def _of_level(result: CellResult, settings: Settings, level: int) -> Record:
    health, steps = result.health.sums, result.health.sums["steps"][level]
    return {
        "h": result.horizon / settings.steps[level],
        "paths": result.paths,
        "failed_paths": int(health["failed"][level]),
        "truncated_share": float(health["truncated"][level] / steps),
        "steps": settings.steps[level],
        "lost_paths": int(health["lost"][level]),
        **_means(health, level),
    }


def _means(health: Mapping[str, Array], level: int) -> dict[str, float]:
    """Return each cost's mean over the steps that have it; NaN if none has."""
    costs = [name.removeprefix(COST) for name in health if name.startswith(COST)]
    counts = {name: health[f"{COUNTED}{name}"][level] for name in costs}
    return {f"{MEAN}{n}": float(health[f"{COST}{n}"][level] / counts[n]) if counts[n] else nan for n in costs}
