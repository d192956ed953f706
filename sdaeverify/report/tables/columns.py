"""The columns of all tables of a run, what each means, and its unit; documentation and page have them from here."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from .. import folders

if TYPE_CHECKING:
    from ...contracts.measure import Measure

COLUMNS = "columns.csv"
TEXT, NUMBER, WHOLE, TRUTH = "text", "number", "whole number", "truth value"
MEAN = "mean_"


class Column(NamedTuple):
    """A column.

    Attributes
    ----------
    name, meaning : str
    kind : str
        Text, number, whole number or truth value; an empty cell says that there is none.
    unit : str
        Empty for what has none.
    """

    name: str
    meaning: str
    kind: str = TEXT
    unit: str = ""


def _number(name: str, meaning: str, unit: str = "") -> Column:
    return Column(name, meaning, NUMBER, unit)


TIME = "the problem's time"
NAMES = (
    Column("scheme", "label of the scheme, with the parameters that are not the defaults"),
    Column("problem", "label of the problem, with the parameters that are not the defaults"),
    Column("measure", "name of the measure"),
    Column("quantity", "what is measured: a component, an observable, a constraint; @T at the final time only"),
)
RUN = Column("run", "which run the row is of: 0 for that of run.json, n for the n-th of its earlier ones", WHOLE)
VERDICTS = (
    *NAMES,
    Column("view", "form in which the scheme gets the problem; empty for the problem as it is"),
    Column("verdict", "verified, refuted, inconclusive, out_of_scope (no claim), diverged, error or not_run"),
    Column("claim", "what is claimed of the quantity; empty where nothing is"),
    _number("margin", "by which an order may be below the claim"),
    _number("local_order", "order of one step, without sampling error; inf where one step is exact"),
    _number("path_order", "order of the errors along paths, where they tell one"),
    _number("path_low", "lower end of its interval at the confidence of the run"),
    _number("path_high", "upper end of its interval"),
    _number("value", "what the measure estimates beside or instead of an order along paths", "see value_of"),
    _number("value_low", "lower end of its interval, or of what can be proved", "see value_of"),
    _number("value_high", "upper end of its interval, or of what can be proved", "see value_of"),
    Column("value_of", "what the value is"),
    Column("decided_by", "tier that decides the claim: T0 contract, T1 one step, T2 without sampling, T3 paths"),
    Column("guarded_by", "what would have shown that the tier errs"),
    Column("reason", "why the verdict is what it is, and why paths tell no order"),
    Column("reason_kind", "kinds of the parts of the reason: rows of a kind say the same with other numbers"),
    _number("p_verified", "p-value of the hypothesis that the claim fails; empty without sampling error"),
    _number("p_refuted", "p-value of the hypothesis that the claim holds; empty without sampling error"),
    Column("paths", "paths that were sampled of the cell", WHOLE),
    RUN,
)
NOT_APPLICABLE = (*NAMES, Column("reason", "why the measure does not apply"), RUN)
LEVELS = (
    *NAMES,
    _number("h", "step size", TIME),
    _number("estimate", "size at this step size of what the measure measures: error, residual, radius, share, count"),
    _number("std_error", "its standard error; 0 without sampling error"),
    Column("paths", "paths that were sampled", WHOLE),
    Column("failed_paths", "paths that a step without root or a value that is not finite ended", WHOLE),
    _number("truncated_share", "share of the steps that the scheme truncated"),
    Column("steps", "steps on a path", WHOLE),
    Column("lost_paths", "paths on which the solution itself ended", WHOLE),
)
DETAILS = (
    *NAMES,
    Column("method", "how the quantity was measured"),
    Column("claim_source", "who claims it, and where"),
    _number("seconds", "time of the scheme on the problem, all its measures together", "s"),
    _number("step_seconds", "mean time of a step on a path, what is noted of it included", "s"),
)
FILES = {folders.VERDICTS: VERDICTS, folders.NOT_APPLICABLE: NOT_APPLICABLE, folders.LEVELS: LEVELS}


def details_file(measure: str) -> str:
    """Return the name of the file with the details of a measure."""
    return f"{folders.DETAILS}/{measure}.csv"


def names(columns: Iterable[Column]) -> tuple[str, ...]:
    """Return the names of columns."""
    return tuple(column.name for column in columns)


def dictionary(measures: "Iterable[Measure]") -> Iterator[dict[str, str]]:
    """Yield a row for each column of each table: file, column, kind, unit, meaning.

    Parameters
    ----------
    measures : iterable of Measure
        That the tables may be about.
    """
    known = list(measures)
    further = {name: meaning for measure in known for name, meaning in measure.level_columns.items()}
    for file, columns in FILES.items():
        yield from (_row(file, column) for column in columns)
        if columns is LEVELS:
            yield from _column_rows(file, further)
            yield _row(file, _number(f"{MEAN}*", "mean over steps and paths of a cost that the scheme reports"))
    for measure in known:
        file = details_file(measure.name)
        yield from (_row(file, column) for column in DETAILS)
        yield from _column_rows(file, measure.detail_columns)


def _column_rows(file: str, further: Mapping[str, str]) -> Iterator[dict[str, str]]:
    return (_row(file, Column(name, meaning, "")) for name, meaning in further.items())


def _row(file: str, column: Column) -> dict[str, str]:
    return {
        "file": file,
        "column": column.name,
        "kind": column.kind,
        "unit": column.unit,
        "meaning": column.meaning,
    }
