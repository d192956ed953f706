"""Columns of all tables of a run with their meanings and units; documentation and page use them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from .. import folders
from ..cells import WHOLE, Column, number_column
from ..verdict_row import VERDICTS

if TYPE_CHECKING:
    from ...contracts.measure import Measure

COLUMNS = "columns.csv"
MEAN = "mean_"
TIME = "the problem's time"
NAMES = VERDICTS[:4]
NOT_APPLICABLE = (*NAMES, Column("reason", "why the measure does not apply"))
ABSENT_GROUPS = (
    NAMES[0],
    Column("problems", "labels of all problems to which the measures do not apply for this reason"),
    Column("measures", "names of these measures"),
    *NOT_APPLICABLE[3:],
)
LEVELS = (
    *NAMES,
    number_column("h", "step size", TIME),
    number_column("estimate", "measured size at this step size: error, residual, radius, share, count"),
    number_column("std_error", "its standard error; 0 without sampling error"),
    Column("paths", "paths that were sampled", WHOLE),
    Column("failed_paths", "paths ended by a step without root or by a value that is not finite", WHOLE),
    number_column("truncated_share", "share of the steps that the scheme truncated"),
    Column("steps", "steps on a path", WHOLE),
    Column("lost_paths", "paths on which the solution itself ended", WHOLE),
)
DETAILS = (
    *NAMES,
    Column("method", "how the quantity was measured"),
    Column("claim_source", "source of the claim"),
    number_column("seconds", "time of the scheme on the problem, all its measures together", "s"),
    Column("traceback", "traceback of the error; empty without an error"),
    number_column("step_seconds", "mean time of a step on a path, including the recording of results", "s"),
)
# Name of the table of details of verdicts on classes of equations.
CLASSES = "classes"
CLASS_FURTHER = (
    Column("motions", "largest number of Brownian motions examined", WHOLE),
    number_column("order", "largest order whose conditions hold, as far as they were examined"),
    Column(
        "held",
        "order conditions or random members on which the claim holds; without a claim of all conditions",
        WHOLE,
    ),
    Column("of", "number of these conditions", WHOLE),
    Column("first", "first condition that does not hold, as a formula of trees"),
    Column("found", "value of the scheme for the integral or mean of the condition"),
    Column("wanted", "value of the exact solution; I is the integral itself"),
    Column("premise", "what a refuted scheme solves instead, if known; premises of the conditions, or why one fails"),
    Column("modified", "equation solved to one order more, as lines; of refuted weak orders, or with --modified"),
    Column("modified_terms", "its terms, one a line: trees, colon, formula"),
)
CLASS_DETAILS = (*NAMES, *CLASS_FURTHER)
# Columns of the classes of a result, each row of which joins a row of verdicts and a row of details.
CLASS_COLUMNS = (
    NAMES[0],
    Column("class", "class of equations; the verdict holds for every smooth equation of the class"),
    NAMES[2],
    number_column("claim", "least order claimed for the class; empty without a claim"),
    VERDICTS[5],
    *CLASS_FURTHER,
)
FILES = {
    folders.VERDICTS: VERDICTS,
    folders.NOT_APPLICABLE: ABSENT_GROUPS,
    folders.LEVELS: LEVELS,
    folders.CLASSES: CLASS_DETAILS,
}


def details_file(measure: str) -> str:
    """Return the name of the file with the details of a measure."""
    return f"{folders.DETAILS}/{measure}.csv"


def dictionary(measures: "Iterable[Measure]") -> Iterator[dict[str, str]]:
    """Yield a row for each column of each table: file, column, kind, unit, meaning.

    Parameters
    ----------
    measures : iterable of Measure
        Measures whose columns are included.
    """
    known = list(measures)
    further = {name: meaning for measure in known for name, meaning in measure.level_columns.items()}
    for file, columns in FILES.items():
        yield from (_row(file, column) for column in columns)
        if columns is LEVELS:
            yield from _column_rows(file, further)
            yield _row(file, number_column(f"{MEAN}*", "mean over steps and paths of a cost that the scheme reports"))
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
