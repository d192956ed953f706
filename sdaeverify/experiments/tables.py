"""The means of an experiment beside what the paper prints and what is exact, and where these disagree."""

from collections.abc import Iterator
from math import hypot, isfinite, nan, sqrt
from typing import NamedTuple

import pandas as pd

from ..experiment import Experiment, Row
from ..forms import Problem
from ..specs import ProblemSpec
from ..truths import InvariantMean, Moment
from .run import ExperimentRun
from .sample import Sample

# Two means agree that differ by no more than four standard errors, and half a unit of what is printed: by chance they
# disagree once in 16000 times.
STANDARD_ERRORS = 4.0
AGREES, DISAGREES = "agrees", "disagrees"


class Exact(NamedTuple):
    """The exact mean and where it is from; NaN if it is not known."""

    value: float = nan
    source: str = ""


class Line(NamedTuple):
    """A row with everything that stands in it.

    Attributes
    ----------
    row : Row
    h : float
    sample : Sample
    exact : Exact
    """

    row: Row
    h: float
    sample: Sample
    exact: Exact

    @property
    def error(self) -> float:
        """Our mean minus the exact value."""
        return self.sample.value - self.exact.value

    @property
    def print_to_ours(self) -> float:
        """The printed mean minus ours."""
        return self.row.printed.value - self.sample.value if self.row.printed else nan

    @property
    def print_to_exact(self) -> float:
        """The printed mean minus the exact value."""
        return self.row.printed.value - self.exact.value if self.row.printed else nan

    @property
    def print_and_ours(self) -> str:
        """Whether the print agrees with our mean: both have a sampling error."""
        return self._compared(self.print_to_ours, hypot(self.print_std_error, self.sample.std_error))

    @property
    def print_and_exact(self) -> str:
        """Whether the print agrees with the exact value: only the print has a sampling error."""
        return self._compared(self.print_to_exact, self.print_std_error)

    @property
    def print_std_error(self) -> float:
        """Standard error of the printed mean: of a path as here, over the root of the paper's number of paths."""
        return self.sample.deviation / sqrt(self.row.printed.paths) if self.row.printed else nan

    def _compared(self, difference: float, std_error: float) -> str:
        if self.row.printed is None or not isfinite(difference) or not isfinite(std_error):
            return ""
        allowed = self.row.printed.half_unit + STANDARD_ERRORS * std_error
        return AGREES if abs(difference) <= allowed else DISAGREES


def lines(run: ExperimentRun) -> list[Line]:
    """Return the rows as they are now."""
    found = {row: line for task, rows in run.plan.groups for row, line in _group(run, task.spec, rows)}
    return [found[row] for row in run.plan.rows]


def table(found: list[Line]) -> pd.DataFrame:
    """Return the rows as a table, numbers with all their digits."""
    return pd.DataFrame([_record(line) for line in found])


def in_words(found: list[Line]) -> Iterator[str]:
    """Yield what could not be measured, one line for each scheme and step size."""
    for row, h, sample, _ in found:
        where = f"{row.scheme} on {row.problem}, h = {h:.4g}"
        if sample.error:
            yield f"{where}: {sample.error}"
        elif not sample.paths:
            yield f"{where}: not reached"
        elif sample.lost:
            yield f"{where}: {sample.lost} of {sample.paths} paths are lost"
        if sample.without_root:
            yield f"{where}: on {sample.without_root} of {sample.paths} paths a step found no root"


def _group(run: ExperimentRun, spec: ProblemSpec, rows: tuple[Row, ...]) -> Iterator[tuple[Row, Line]]:
    problem = spec.build()
    for row in rows:
        exact = _exact(run.plan.experiment, problem, row.observable)
        yield row, Line(row, problem.horizon / row.steps, run.sample_of(row), exact)


def _exact(experiment: Experiment, problem: Problem, observable: str) -> Exact:
    for truth in problem.truths:
        if isinstance(truth, Moment) and truth.observable == observable:
            return Exact(float(truth.value(problem.horizon)), truth.source)
    for truth in problem.truths:
        if experiment.equilibrium and isinstance(truth, InvariantMean) and truth.observable == observable:
            return Exact(truth.value, truth.source)
    return Exact()


def _record(line: Line) -> dict[str, object]:
    row, sample = line.row, line.sample
    return {
        "problem": row.problem,
        "scheme": row.scheme,
        "steps": row.steps,
        "h": line.h,
        "observable": row.observable,
        "printed": row.printed.digits if row.printed else "",
        "printed_paths": row.printed.paths if row.printed else "",
        "printed_std_error": line.print_std_error,
        "mean": sample.value,
        "std_error": sample.std_error,
        "paths": sample.paths,
        "exact": line.exact.value,
        "exact_source": line.exact.source,
        "mean_minus_exact": line.error,
        "printed_minus_mean": line.print_to_ours,
        "printed_and_mean": line.print_and_ours,
        "printed_minus_exact": line.print_to_exact,
        "printed_and_exact": line.print_and_exact,
        "without_root": sample.without_root,
        "lost": sample.lost,
        "error": sample.error,
    }
