"""Rows of the table of verdicts: columns with meanings, conversion from findings, and reading from a file.

A row is the public form of a finding: a column has the same meaning in all measures, and no order is estimated from
noise. A new column is a field of `VerdictRow` that `VerdictRow.from_finding` fills: tables, JSON, the page, `show`,
notebooks and the dictionary of columns are derived from the fields.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING, Any, NamedTuple

from ..contracts.claimed import Order
from ..contracts.finding import AT_ONCE, CONTRACT, ONE_STEP, SAMPLED, Finding, Kind, Verdict, tier_name
from ..verdicts.path_tests import RESOLVED
from .cells import NUMBER, TEXT, WHOLE, Column, Row, number, text
from .folders import Key, class_in, key_in

if TYPE_CHECKING:
    from ..study import CellResult

ORDER, AT_END = "order", "weak order at T by moments"
# Verdicts that are decisions.
DECIDED = {"verified", "refuted"}


class Interval(NamedTuple):
    """Estimate with its interval at the run's confidence; NaN if unknown."""

    value: float = nan
    low: float = nan
    high: float = nan

    @property
    def known(self) -> bool:
        """Whether there is an estimate."""
        return not isnan(self.value)


# Metadata of columns that the page does not show.
OFF_PAGE: dict[str, Any] = {"on_page": False}


def _text(meaning: str, **told: Any) -> Any:
    return field(default="", metadata={"meaning": meaning, "kind": TEXT, **told})


def _number(meaning: str, unit: str = "", **told: Any) -> Any:
    return field(default=nan, metadata={"meaning": meaning, "kind": NUMBER, "unit": unit, **told})


def _whole(meaning: str, **told: Any) -> Any:
    return field(default=0, metadata={"meaning": meaning, "kind": WHOLE, **told})


@dataclass(frozen=True, kw_only=True)
class VerdictRow:
    """Verdict on a quantity of a cell; the metadata of a field gives the meaning of its column."""

    scheme: str = _text("label of the scheme, with the parameters that are not the defaults")
    problem: str = _text("label of the problem, with the parameters that are not the defaults; or every-equation")
    measure: str = _text("name of the measure")
    quantity: str = _text("measured quantity: a component, an observable, a constraint; @T at the final time only")
    view: str = _text("form in which the scheme receives the problem; empty for the problem's own form")
    verdict: str = _text("verified, refuted, inconclusive, out_of_scope (no claim), diverged, error or not_run")
    claim: str = _text("claimed value of the quantity; empty without a claim")
    claimed_order: float = _number("least claimed order; empty without one")
    margin: float = _number("amount by which an order may be below the claim")
    local_order: float = _number("order of one step, without sampling error; inf where one step is exact")
    path_order: float = _number("order of the errors along paths, if it can be estimated")
    path_low: float = _number("lower end of its interval at the confidence of the run")
    path_high: float = _number("upper end of its interval")
    value: float = _number("quantity estimated in addition to or instead of an order along paths", "see value_of")
    value_low: float = _number("lower end of its interval, or a proved lower bound", "see value_of")
    value_high: float = _number("upper end of its interval, or a proved upper bound", "see value_of")
    value_of: str = _text("meaning of the value")
    decided_by: str = _text(
        "tier that decides the claim: T0 contract, T1 one step, T2 without sampling, T3 paths, TA whole classes"
    )
    guarded_by: str = _text("evidence that would have shown a wrong verdict of the tier", label="guarded by")
    resolution: float = _number(
        "largest error of the limit that could be undetected; inf if unknown", "the quantity's size"
    )
    order_resolution: float = _number(
        "largest share of a term of half an order less in the error at the finest step if only paths decide",
        "the error",
        label="order resolution",
    )
    reason: str = _text("why the verdict was given, and why paths show no order")
    reason_kind: str = _text(
        "kinds of the parts of the reason: rows of a kind say the same with other numbers", **OFF_PAGE
    )
    p_verified: float = _number(
        "p-value of the hypothesis that the claim fails; empty without sampling error", **OFF_PAGE
    )
    p_refuted: float = _number(
        "p-value of the hypothesis that the claim holds; empty without sampling error", **OFF_PAGE
    )
    paths: int = _whole("paths that were sampled of the cell")

    @classmethod
    def from_finding(cls, found: "Finding", result: "CellResult") -> "VerdictRow":
        """Create the row of a finding."""
        cell = result.cell
        return cls(
            **key_in(cell, found.quantity)._asdict(),
            view=cell.view,
            paths=result.paths,
            **_told(found, cell.measure.value_of),
        )

    @classmethod
    def from_row(cls, row: Row) -> "VerdictRow":
        """Create the row from the values or texts of a table."""
        return cls(**{column.name: READERS[column.kind](row, column.name) for column in VERDICTS})

    @property
    def path(self) -> Interval:
        """Order along paths with its interval."""
        return Interval(self.path_order, self.path_low, self.path_high)

    @property
    def estimate(self) -> Interval:
        """Estimate of the measure other than an order along paths."""
        return Interval(self.value, self.value_low, self.value_high)

    @property
    def labelled(self) -> list[str]:
        """Label and value of each nonempty column that has a label."""
        told = ((column.label, _in_words(getattr(self, column.name))) for column in LABELLED)
        return [f"{label} {words}" for label, words in told if words]

    @property
    def key(self) -> Key:
        """Scheme, problem, measure and quantity."""
        return Key(self.scheme, self.problem, self.measure, self.quantity)

    @property
    def of_class(self) -> bool:
        """Whether the row is about a class of equations."""
        return class_in(self.problem) is not None

    @property
    def cells(self) -> dict[str, object]:
        """Values of the columns by name."""
        return dict(vars(self))

    @property
    def record(self) -> dict[str, Any]:
        """Values of the columns for JSON, in which NaN is null and infinity is a text."""
        return {name: _jsonable(value) for name, value in self.cells.items()}


# Number of digits from which a whole number is rejected, because a float may not represent it.
LONGEST_WHOLE = 16

VERDICTS = tuple(Column(f.name, **f.metadata) for f in fields(VerdictRow))
LABELLED = tuple(column for column in VERDICTS if column.label)
READERS: dict[str, Callable[[Row, str], Any]] = {
    TEXT: text,
    NUMBER: number,
    WHOLE: lambda row, name: _read_whole(text(row, name)),
}


def _read_whole(told: str) -> int:
    # A file of another source may hold any number.
    return int(told) if told.isdecimal() and len(told) < LONGEST_WHOLE else 0


def _in_words(value: object) -> str:
    if isinstance(value, float):
        return "" if isnan(value) else f"{value:.4g}"
    return str(value or "")


def _jsonable(value: object) -> object:
    if isinstance(value, float):
        return None if isnan(value) else value if isfinite(value) else str(value)
    return None if value == "" else value


def _told(found: "Finding", value_of: str) -> dict[str, Any]:
    """Return the columns of a finding; `value_of` names the estimate of its measure, empty for an order."""
    kind, claimed = found.value_of or value_of or ORDER, found.claim and found.claim.value
    order = claimed if isinstance(claimed, Order) else None
    path, why = _along_paths(found) if kind == ORDER else (Interval(), "")
    value, told = _value(found, kind, path)
    reason = found.reason.then(why)
    method, decided = found.method, found.verdict in DECIDED
    return {
        "claim": str(found.claim or ""),
        "claimed_order": order.least if order else nan,
        "margin": order.margin if order else nan,
        "local_order": _local_order(found, kind),
        **dict(zip(("path_order", "path_low", "path_high"), path, strict=True)),
        **dict(zip(("value", "value_low", "value_high"), value, strict=True)),
        "value_of": told,
        "verdict": str(found.verdict),
        "decided_by": tier_name(found.tier) if method and (decided or found.tier == CONTRACT) else "",
        "guarded_by": method.guarded_by if method and decided else "",
        "resolution": found.resolution if found.claim else nan,
        "order_resolution": found.order_resolution,
        "reason": str(reason) if found.verdict in {Verdict.ERROR, Verdict.NOT_RUN} else reason.sentence,
        "reason_kind": ", ".join(found.reason.kinds),
        "p_verified": found.p_verified,
        "p_refuted": found.p_refuted,
    }


def _detail(found: "Finding", name: str) -> float:
    return float(str(found.details.get(name, nan)))


def _estimate(found: "Finding") -> Interval:
    return Interval(found.estimate, found.low, found.high)


def _along_paths(found: "Finding") -> tuple[Interval, str]:
    """Return the order along paths, and the reason if paths were sampled but give none."""
    told = "informative" in found.details
    sampled = found.method and (found.tier == SAMPLED or found.method.guard)
    order = Interval(*(_detail(found, f"slope{end}") for end in ("", "_low", "_high"))) if told else Interval()
    order = order if told else _estimate(found) if sampled else Interval()
    if not order.known:
        return Interval(), ""
    if told and not found.details["informative"]:
        resolved = _detail(found, "resolved")
        noise = f"bias below sampling noise ({resolved:.1f} standard errors; {RESOLVED:g} needed)"
        # The reason already mentions a change of sign or a doubt of a guard.
        said = resolved >= RESOLVED or not isnan(found.reason.standard_errors) or found.reason.has(Kind.GUARD)
        return Interval(), "" if said else noise
    if not (isfinite(order.low) and isfinite(order.high)):
        return Interval(), "no finite interval along paths" if isnan(found.reason.standard_errors) else ""
    return order, ""


def _local_order(found: "Finding", kind: str) -> float:
    known = _detail(found, "local_order")
    # A guarded estimate is that of the paths, unless the finding has a separate order along paths.
    of_paths = found.method and found.method.guard and "informative" not in found.details
    alone = isnan(known) and kind == ORDER and found.method and found.tier == ONE_STEP and not of_paths
    return found.estimate if alone else known


def _value(found: "Finding", kind: str, path: Interval) -> tuple[Interval, str]:
    if kind != ORDER:
        return (value, kind) if (value := _estimate(found)).known else (Interval(), "")
    if not isnan(moments := _detail(found, "moment_order")):
        return Interval(moments), AT_END
    at_once = found.method and found.tier == AT_ONCE
    value = _estimate(found) if at_once and isnan(_detail(found, "local_order")) and not path.known else Interval()
    # Possibly only a lower bound of the order is known.
    told = value if isfinite(value.low) or value.value == inf else Interval()
    return (told, ORDER) if told.known else (Interval(), "")
