"""Tables of means of schemes: experiments whose rows are means, or mean squares against a fine run."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sdaeverify import Array, InvariantMean, Moment, Problem, ProblemError
from sdaeverify.measuring import Estimate, jackknife
from sdaeverify.numerics import slope_weights

from .exhibit import Exhibit, Panel, Printed, TableEntry
from .experiment import Budget, Experiment, Note, RunFound, SchemeMean, SchemeRun, SchemeValue, Work
from .mean_sample import MeanSample

if TYPE_CHECKING:
    from .run import ExperimentEvidence

# Least number of step sizes for a fit.
FEWEST = 3
# Symbol of the reference of a row.
REFERENCE = "ref"


class FineRun(NamedTuple):
    """Pathwise reference of a row: a run with shorter steps on the same Brownian paths.

    Attributes
    ----------
    scheme : str
        Label of a registered scheme.
    steps : int
        Number of steps up to the final time.
    """

    scheme: str
    steps: int


@dataclass(frozen=True, kw_only=True)
class Row:
    """The mean of an observable, or the mean square of its difference from a reference.

    Attributes
    ----------
    problem, scheme : str
        Labels of a registered problem and scheme.
    steps : int
        Number of steps up to the final time.
    observable : str
        Name of one of the problem's observables.
    printed : Printed or None
        Number printed in the paper.
    costly : bool
        Whether the row is run at full budget only.
    at : int or None
        Number of steps after which the mean is taken; by default all.
    reference : FineRun or None
        With a reference the row is E (phi - phi_reference)^2 for the observable phi, otherwise E phi.
    """

    problem: str
    scheme: str
    steps: int
    observable: str
    printed: Printed | None = None
    costly: bool = False
    at: int | None = None
    reference: FineRun | None = None

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise ProblemError(f"a row needs at least 1 step, got {self.steps}")
        if not 1 <= self.steps_made <= self.steps:
            raise ProblemError(f"a mean must be taken after 1 to {self.steps} steps, got {self.at!r}")
        if self.reference and (self.reference.steps <= self.steps or not _doubles(self.reference.steps, self.steps)):
            raise ProblemError(
                f"steps of a reference must be {self.steps} times a power of 2, got {self.reference.steps}"
            )

    @property
    def steps_made(self) -> int:
        """Number of steps after which the mean is taken."""
        return self.steps if self.at is None else self.at

    @property
    def value(self) -> SchemeValue:
        """Value whose mean is taken."""
        return SchemeValue(self.scheme, self.steps, self.observable, self.steps_made)

    @property
    def reference_value(self) -> SchemeValue | None:
        """Value of the reference, or None."""
        if self.reference is None:
            return None
        scheme, steps = self.reference
        return SchemeValue(scheme, steps, self.observable, self.steps_made * (steps // self.steps))

    @property
    def values(self) -> tuple[SchemeValue, ...]:
        """All values from which the row is computed."""
        return (self.value, self.reference_value) if self.reference_value else (self.value,)


class MeanLine(NamedTuple):
    """A row with its results.

    Attributes
    ----------
    row : Row
    h, time : float
        Step size, and time of the mean.
    sample : MeanSample
    exact : float
        Exact mean; NaN if unknown.
    exact_source : str
    scheme_mean : SchemeMean
        Mean of the scheme without sampling.
    """

    row: Row
    h: float
    time: float
    sample: MeanSample
    exact: float = nan
    exact_source: str = ""
    scheme_mean: SchemeMean = SchemeMean()

    @property
    def entry(self) -> TableEntry:
        """Entry of the table."""
        row, sample, square = self.row, self.sample, self.row.reference is not None
        what = f"({row.observable} - {REFERENCE})^2" if square else row.observable
        factor, rate = self.scheme_mean[1:]
        reference_scheme, reference_steps = row.reference or ("", "")
        return TableEntry(
            group=f"{row.scheme} on {row.problem}",
            at={"h": self.h, **({} if row.at is None else {"t": self.time}), "mean of": what},
            value=sample.value,
            std_error=sample.std_error,
            paths=sample.paths,
            effective=sample.effective,
            printed=row.printed,
            printed_std_error=sample.deviation / sqrt(row.printed.paths) if row.printed else 0.0,
            exact=self.exact,
            exact_source=self.exact_source,
            expected=self.scheme_mean.value,
            more={
                "problem": row.problem, "scheme": row.scheme, "steps": row.steps, "time": self.time,
                "observable": row.observable, "reference_scheme": reference_scheme,
                "reference_steps": reference_steps, "scheme_growth_factor": factor, "growth_rate": rate,
                "without_root": sample.without_root, "lost": sample.lost, "error": sample.error,
            },
        )  # fmt: skip

    @property
    def in_words(self) -> Iterator[str]:
        """Failures of the row, in sentences."""
        row, sample = self.row, self.sample
        where = f"{row.scheme} on {row.problem}, h = {self.h:.4g}"
        if sample.error:
            yield f"{where}: {sample.error}"
        elif not sample.paths:
            yield f"{where}: not reached"
        elif sample.lost:
            yield f"{where}: {sample.lost} of {sample.paths} paths are lost"
        if sample.without_root:
            yield f"{where}: on {sample.without_root} of {sample.paths} paths a step found no root"


@dataclass(frozen=True, kw_only=True)
class MeanTable(Experiment):
    """An experiment of means.

    All rows of a problem run on the same Brownian paths. The exact value of a row is the moment of the problem at the
    time of the row.

    Attributes
    ----------
    name, title, source, paths, full_paths, block, notes
        As in `Experiment`.
    rows : tuple of Row
        Rows; the numbers of steps on one problem are the least one times powers of 2.
    equilibrium : bool
        Whether the final time is large enough for means to equal those of the invariant law to all digits.
    """

    name: str
    title: str
    source: str
    rows: tuple[Row, ...]
    paths: int = Experiment.paths
    full_paths: int | None = None
    block: int = Experiment.block
    notes: tuple[str, ...] = ()
    equilibrium: bool = False

    def __post_init__(self) -> None:
        if not self.rows:
            raise ProblemError(f"experiment {self.name!r} has no rows")
        for problem in dict.fromkeys(row.problem for row in self.rows):
            steps = [value.steps for row in self.rows if row.problem == problem for value in row.values]
            if not all(_doubles(count, min(steps)) for count in steps):
                raise ProblemError(
                    f"experiment {self.name!r}: steps on {problem} must be the least times powers of 2, got {steps}"
                )

    def chosen(self, budget: Budget) -> tuple[Row, ...]:
        """Return the rows of a budget."""
        return tuple(row for row in self.rows if budget is Budget.FULL or not row.costly)

    def work(self, budget: Budget) -> Work:
        """Return one run for each problem, scheme and number of steps."""
        notes: dict[tuple[str, str, int], dict[str, set[int]]] = {}
        for row in self.chosen(budget):
            for value in row.values:
                noted = notes.setdefault((row.problem, value.scheme, value.steps), {})
                noted.setdefault(value.observable, set()).add(value.at)
        return {
            key: SchemeRun(
                problem=key[0],
                scheme=key[1],
                steps=key[2],
                notes=tuple(Note(name, name, tuple(sorted(at))) for name, at in noted.items()),
            )
            for key, noted in notes.items()
        }

    def exhibit(self, evidence: "ExperimentEvidence") -> Exhibit:
        """Return means with printed and exact values, orders from rows with a reference, and the panels."""
        found = self.lines(evidence)
        fitted = orders(found)
        return Exhibit(
            tuple(line.entry for line in found),
            self.panels(found, evidence),
            (*_references(found), *(order.in_words for order in fitted), *_growths(found)),
            tuple(word for line in found for word in line.in_words),
        )

    def panels(self, found: "Sequence[MeanLine]", evidence: "ExperimentEvidence") -> tuple[Panel, ...]:
        """Return the panels of the rows; empty by default."""
        return ()

    def lines(self, evidence: "ExperimentEvidence") -> "list[MeanLine]":
        """Return the rows with their results."""
        rows = self.chosen(evidence.budget)
        means = {
            problem: evidence.scheme_means(problem, [row.value for row in rows if _has_mean(row, problem, evidence)])
            for problem in dict.fromkeys(row.problem for row in rows)
        }
        return [self._line(row, evidence, means[row.problem]) for row in rows]

    def _line(self, row: Row, evidence: "ExperimentEvidence", means: Mapping[SchemeValue, SchemeMean]) -> "MeanLine":
        problem = evidence.problem(row.problem)
        h, t = problem.horizon / row.steps, problem.horizon * (row.steps_made / row.steps)
        sample = _sample(row, evidence)
        if row.reference:
            return MeanLine(row, h, t, sample)
        mean = means.get(row.value, SchemeMean())
        return MeanLine(row, h, t, sample, *self._exact(problem, row.observable, t), mean)

    def _exact(self, problem: Problem, observable: str, t: float) -> tuple[float, str]:
        for truth in problem.truths:
            if isinstance(truth, Moment) and truth.observable == observable:
                return float(truth.value(t)), truth.source
        for truth in problem.truths:
            if self.equilibrium and isinstance(truth, InvariantMean) and truth.observable == observable:
                return truth.value, truth.source
        return nan, ""


class FittedOrder(NamedTuple):
    """The slope of log2 (E e^2)^(1/2) against log2 h.

    Attributes
    ----------
    row : Row
        One of the rows of the fit.
    step_sizes : int
        Number of rows.
    estimate : Estimate
        Estimate, with a standard error that accounts for common paths of the rows.
    """

    row: Row
    step_sizes: int
    estimate: Estimate

    @property
    def in_words(self) -> str:
        """The order in a sentence."""
        row, (value, std_error) = self.row, self.estimate
        error = f"root mean square of {row.observable} - {REFERENCE}"
        order = f"{value:.4f} +- {std_error:.4f}"
        return f"{row.scheme} on {row.problem}: order {order} of the {error}, from {self.step_sizes} step sizes"


def orders(found: Sequence[MeanLine]) -> list[FittedOrder]:
    """Return the orders of rows that differ only in their step size, for at least three of them."""
    fits: dict[tuple[object, ...], list[MeanLine]] = {}
    for line in found:
        if line.row.reference is not None and line.sample.value > 0.0:
            row = line.row
            fits.setdefault((row.problem, row.scheme, row.observable, row.reference, line.time), []).append(line)
    return [_order(lines) for lines in fits.values() if len({line.h for line in lines}) >= FEWEST]


def _order(lines: Sequence[MeanLine]) -> FittedOrder:
    h = np.array([line.h for line in lines])
    groups = np.array([line.sample.groups for line in lines])
    weights = slope_weights(np.log2(h))

    def slope(means: Array) -> float:
        return float(weights @ np.log2(np.sqrt(means)))

    return FittedOrder(lines[0].row, len(lines), jackknife(groups[..., 1].T, groups[0, :, 0], slope))


def _sample(row: Row, evidence: "ExperimentEvidence") -> MeanSample:
    """Return the sample of a row, or a sample with the error."""
    found = [_look_up_notes(value, evidence.run((row.problem, value.scheme, value.steps))) for value in row.values]
    if error := next((each for each in found if isinstance(each, str)), ""):
        return MeanSample(error=error)
    values, without_root, lost = (np.array(parts) for parts in zip(*found, strict=True))
    y = (values[0] - values[1]) ** 2 if row.reference else values[0]
    return MeanSample.of(y, int(without_root.any(axis=0).sum()), int(lost.any(axis=0).sum()))


def _look_up_notes(value: SchemeValue, found: RunFound) -> tuple[Array, Array, Array] | str:
    if found.error:
        return found.error
    if value.observable not in found.noted:
        return np.zeros(0), np.zeros(0, dtype=bool), np.zeros(0, dtype=bool)
    note = found.noted[value.observable]
    index = note.at.index(value.at) if not note.error else 0
    return note.error or (note.values[index], note.without_root[index], note.lost[index])


def _has_mean(row: Row, problem: str, evidence: "ExperimentEvidence") -> bool:
    found = evidence.run((row.problem, row.scheme, row.steps))
    return row.problem == problem and row.reference is None and not found.error and found.paths > 0


def _references(found: Sequence[MeanLine]) -> Iterator[str]:
    for reference, problem in dict.fromkeys((line.row.reference, line.row.problem) for line in found):
        if reference:
            yield (
                f"{REFERENCE}: {reference.scheme} with {reference.steps} steps to the final time, "
                f"on the same Brownian paths of {problem}"
            )


def _growths(found: Sequence[MeanLine]) -> Iterator[str]:
    for line in {(line.row.problem, line.row.scheme, line.h): line for line in found}.values():
        _, factor, rate = line.scheme_mean
        if isfinite(factor):
            where = f"{line.row.scheme} on {line.row.problem}, h = {line.h:.4g}"
            equation = f", those of the equation as e^({rate:.4f} t)" if isfinite(rate) else ""
            yield f"{where}: second moments change by the factor {factor:.6f} a step{equation}"


def _doubles(steps: int, least: int) -> bool:
    return steps % least == 0 and (steps // least).bit_count() == 1
