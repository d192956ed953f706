"""The means of an experiment beside what the paper prints and what is exact, and where these disagree."""

from collections.abc import Iterator
from math import hypot, isfinite, nan, sqrt
from typing import NamedTuple

import pandas as pd

from ...contracts.experiment import Experiment, Row
from ...forms import Problem
from ...forms.truths import InvariantMean, Moment
from .block import BlockTask
from .run import ExperimentRun
from .sample import Sample
from .scheme_means import SchemeMean, scheme_means

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
    time : float
        When the mean is taken.
    sample : Sample
    exact : Exact
    scheme_mean : SchemeMean
        What the scheme's mean is without sampling.
    """

    row: Row
    h: float
    time: float
    sample: Sample
    exact: Exact
    scheme_mean: SchemeMean = SchemeMean()

    @property
    def error(self) -> float:
        """Our mean minus the exact value."""
        return self.sample.value - self.exact.value

    @property
    def sampling_error(self) -> float:
        """Our mean minus what the scheme's mean is."""
        return self.sample.value - self.scheme_mean.value

    @property
    def ours_and_scheme(self) -> str:
        """Whether our mean is what the scheme's is: it is not where paths that are too rare to be drawn carry it."""
        return _agreement(self.sampling_error, STANDARD_ERRORS * self.sample.std_error)

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
        half_unit = self.row.printed.half_unit if self.row.printed else nan
        return _agreement(difference, half_unit + STANDARD_ERRORS * std_error)


def lines(run: ExperimentRun) -> list[Line]:
    """Return the rows as they are now."""
    found = {row: line for task, rows in run.plan.groups for row, line in _group(run, task, rows)}
    return [found[row] for row in run.plan.rows]


def table(found: list[Line]) -> pd.DataFrame:
    """Return the rows as a table, numbers with all their digits."""
    return pd.DataFrame([_record(line) for line in found])


def in_words(found: list[Line]) -> Iterator[str]:
    """Yield what could not be measured, one line for each scheme and step size."""
    for line in found:
        row, h, sample = line.row, line.h, line.sample
        where = f"{row.scheme} on {row.problem}, h = {h:.4g}"
        if sample.error:
            yield f"{where}: {sample.error}"
        elif not sample.paths:
            yield f"{where}: not reached"
        elif sample.lost:
            yield f"{where}: {sample.lost} of {sample.paths} paths are lost"
        if sample.without_root:
            yield f"{where}: on {sample.without_root} of {sample.paths} paths a step found no root"


def _group(run: ExperimentRun, task: BlockTask, rows: tuple[Row, ...]) -> Iterator[tuple[Row, Line]]:
    problem, samples = task.spec.build(), [run.sample_of(row) for row in rows]
    measured = zip(task.quantities, samples, strict=True)
    means = scheme_means(
        problem, [each.value for each, sample in measured if each.reference is None and sample.paths]
    )
    for row, quantity, sample in zip(rows, task.quantities, samples, strict=True):
        h, t = problem.horizon / row.steps, problem.horizon * (row.steps_made / row.steps)
        exact = Exact() if quantity.reference else _exact(run.plan.experiment, problem, row.observable, t)
        mean = SchemeMean() if quantity.reference else means.get(quantity.value, SchemeMean())
        yield row, Line(row, h, t, sample, exact, mean)


def _exact(experiment: Experiment, problem: Problem, observable: str, t: float) -> Exact:
    for truth in problem.truths:
        if isinstance(truth, Moment) and truth.observable == observable:
            return Exact(float(truth.value(t)), truth.source)
    for truth in problem.truths:
        if experiment.equilibrium and isinstance(truth, InvariantMean) and truth.observable == observable:
            return Exact(truth.value, truth.source)
    return Exact()


def _agreement(difference: float, allowed: float) -> str:
    if not isfinite(difference) or not isfinite(allowed):
        return ""
    return AGREES if abs(difference) <= allowed else DISAGREES


def _record(line: Line) -> dict[str, object]:
    row, sample = line.row, line.sample
    return {
        "problem": row.problem,
        "scheme": row.scheme,
        "steps": row.steps,
        "h": line.h,
        "time": line.time,
        "observable": row.observable,
        "reference_scheme": row.reference.scheme if row.reference else "",
        "reference_steps": row.reference.steps if row.reference else "",
        "printed": row.printed.digits if row.printed else "",
        "printed_paths": row.printed.paths if row.printed else "",
        "printed_std_error": line.print_std_error,
        "mean": sample.value,
        "std_error": sample.std_error,
        "paths": sample.paths,
        "effective_paths": sample.effective,
        "scheme_mean": line.scheme_mean.value,
        "mean_minus_scheme_mean": line.sampling_error,
        "mean_and_scheme_mean": line.ours_and_scheme,
        "scheme_growth_factor": line.scheme_mean.growth.factor,
        "growth_rate": line.scheme_mean.growth.rate,
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
