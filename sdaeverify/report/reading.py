"""A row of the verdicts as people are told of it: one meaning a field in every measure, and no order of noise."""

from collections.abc import Mapping
from math import inf, isfinite, isnan, nan
from typing import Any, NamedTuple

# What the measures that estimate no order estimate.
VALUES = {
    "stability": "largest stable h",
    "solvability": "share of paths without a root",
    "effort": "iterations a step",
    "moments": "ratio of moments",
}
ORDER, BIAS, RESIDUAL, AT_END = "order", "bias", "largest residual", "weak order at T by moments"
GUARDED = "guarded by "
# Standard errors from which on a mean difference tells something.
RESOLVED = 3.0
# Of verdicts that something decides.
DECIDED = {"verified", "refuted"}

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
    """What a row of the verdicts says.

    Attributes
    ----------
    claim : str
    margin : float
        By which an order may be below the claim; NaN where no order is claimed.
    local_order : float
        Of one step, without sampling error.
    path : Interval
        The order along paths; empty where the paths do not tell one.
    value : Interval
        What the measure estimates beside or instead of an order along paths.
    value_of : str
        What that is.
    verdict : str
    decided_by, guarded_by : str
        Tier, and what would have shown that it errs.
    reason : str
    no_order : str
        Why the paths tell no order; empty where they do or were not asked.
    """

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
    no_order: str = ""


def read_row(row: Row) -> Reading:
    """Read a row of the verdicts, as a table holds it or as text."""
    claim, method, verdict = text(row, "claim"), text(row, "method"), text(row, "verdict")
    kind = _kind(row, claim, method)
    path, why = _along_paths(row, method) if kind == ORDER else (Interval(), "")
    value, value_of = _value(row, kind, path)
    return Reading(
        claim=claim,
        margin=number(row, "margin") if claim.startswith(ORDER) else nan,
        local_order=_local_order(row, kind),
        path=path,
        value=value,
        value_of=value_of,
        verdict=verdict,
        decided_by=text(row, "tier") if verdict in DECIDED else "",
        guarded_by=method.partition(GUARDED)[2] if verdict in DECIDED else "",
        reason=text(row, "reason"),
        no_order=why,
    )


def record(row: Row) -> dict[str, Any]:
    """Return a row of the verdicts as a record for JSON."""
    reading = read_row(row)
    return {
        **{name: text(row, name) for name in ("scheme", "problem", "measure", "quantity")},
        "claim": reading.claim or None,
        "margin": _number(reading.margin),
        "local_order": _number(reading.local_order),
        **_interval("path_order", reading.path),
        **_interval("value", reading.value),
        "value_of": reading.value_of or None,
        "verdict": reading.verdict,
        "decided_by": reading.decided_by or None,
        "guarded_by": reading.guarded_by or None,
        "reason": "; ".join(part for part in (reading.reason, reading.no_order) if part),
        "reproduce": text(row, "reproduce") or None,
    }


def text(row: Row, name: str) -> str:
    """Return a text of a row; empty where it has none."""
    found = row.get(name)
    return "" if found is None or str(found) == "nan" else str(found)


def number(row: Row, name: str) -> float:
    """Return a number of a row; NaN where it has none."""
    try:
        return float(text(row, name) or nan)
    except ValueError:
        return nan


def claimed_order(claim: str) -> float:
    """Return the order that a claim names; NaN where it names none."""
    head, _, value = claim.partition(">= ")
    return float(value) if head.strip() == ORDER else nan


def _kind(row: Row, claim: str, method: str) -> str:
    if text(row, "class") == BIAS or claim.startswith("unbiased"):
        return BIAS
    if method.startswith(RESIDUAL):
        return RESIDUAL
    return VALUES.get(text(row, "measure"), ORDER)


def _estimate(row: Row) -> Interval:
    return Interval(*(number(row, name) for name in ("estimate", "ci_low", "ci_high")))


def _sampled(row: Row, method: str) -> bool:
    return text(row, "tier") == "T3" or GUARDED in method


def _along_paths(row: Row, method: str) -> tuple[Interval, str]:
    """Return the order along paths, and why there is none although paths were sampled."""
    if text(row, "path_order") or text(row, "informative"):
        found = Interval(*(number(row, name) for name in ("path_order", "path_low", "path_high")))
    else:
        found = _estimate(row) if _sampled(row, method) else Interval()
    if not found.known:
        return Interval(), ""
    if text(row, "informative") == "False":
        resolved = number(row, "resolved")
        changes = "its errors change sign between levels"
        return Interval(), f"a mean difference is {resolved:.1f} standard errors" if resolved < RESOLVED else changes
    if not (isfinite(found.low) and isfinite(found.high)):
        return Interval(), "its interval is not finite"
    return found, ""


def _local_order(row: Row, kind: str) -> float:
    found = (number(row, name) for name in ("local_order", "local_weak_order"))
    known = next((order for order in found if not isnan(order)), nan)
    alone = isnan(known) and kind == ORDER and text(row, "tier") == "T1"
    return number(row, "estimate") if alone else known


def _value(row: Row, kind: str, path: Interval) -> tuple[Interval, str]:
    if kind != ORDER:
        return (found, kind) if (found := _estimate(row)).known else (Interval(), "")
    if not isnan(moments := number(row, "moment_order")):
        return Interval(moments), AT_END
    by_operator = text(row, "tier") == "T2" and not text(row, "local_weak_order") and not path.known
    found = _estimate(row) if by_operator else Interval()
    # All that is known may be that an order is at least so high.
    told = found if isfinite(found.low) or found.value == inf else Interval()
    return (told, ORDER) if told.known else (Interval(), "")


def _interval(name: str, estimate: Interval) -> dict[str, Any]:
    low, high = f"{name.removesuffix('_order')}_low", f"{name.removesuffix('_order')}_high"
    return {name: _number(estimate.value), low: _number(estimate.low), high: _number(estimate.high)}


def _number(value: float) -> float | str | None:
    # JSON knows neither infinity nor NaN.
    if isnan(value):
        return None
    return value if isfinite(value) else str(value)
