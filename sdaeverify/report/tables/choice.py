"""Which scheme for a problem: the work that each needs for an accuracy, from the errors and times of a run.

With errors e(n) at numbers of steps n, the steps for an accuracy are where the line through two neighbours, log e
against log n, meets it; beyond the finest level the line goes on with the order along paths, for six levels. The work
is the measured time of so many steps on a path. Errors count where they are clear of their noise.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import ceil, floor, isfinite, log2, log10, nan
from statistics import median
from typing import Any

from ...errors import UsageError
from ..cells import Row, grouped, number
from ..folders import key_of
from ..pictures import AXES, CLEAR, known_order
from ..verdict_row import VerdictRow

# Measures whose levels are errors, which more steps make smaller.
ERRORS = tuple(measure for measure, axis in AXES.items() if axis.paid_by_steps)
# How many times the steps of the finest level an order may tell of: six levels more.
FARTHEST = 64


@dataclass(frozen=True)
class Choice:
    """A scheme for a problem.

    Attributes
    ----------
    scheme, verdict, claim : str
        Its label, and what was found of what it claims.
    order : float
        Along paths, or of one step where paths tell none.
    noise : str
        What it needs to be drawn.
    error : float
        At the finest step size that counts.
    steps : float
        For the accuracy; NaN where that is not known.
    seconds : float
        Of so many steps on a path, measured.
    beyond : bool
        Whether the finest step size is too coarse, so that the order says how many steps are needed.
    """

    scheme: str
    verdict: str
    claim: str
    order: float
    noise: str
    error: float
    steps: float = nan
    seconds: float = nan
    beyond: bool = False

    @property
    def record(self) -> dict[str, Any]:
        """The fields for JSON, which knows neither infinity nor NaN."""
        numbers = ((name, value) for name, value in asdict(self).items())
        return {name: None if isinstance(value, float) and not isfinite(value) else value for name, value in numbers}


@dataclass(frozen=True)
class Curve:
    """The errors of a scheme that count, coarsest first, and the time of one of its steps."""

    row: VerdictRow
    points: tuple[tuple[float, float], ...]
    step_seconds: float


@dataclass(frozen=True)
class Choices:
    """The schemes for a quantity of a problem, the least work first; those of which it is not known come last.

    Attributes
    ----------
    problem, measure, quantity : str
    accuracy : float
    found : tuple of Choice
    quantities : tuple of str
        Of the measure on the problem.
    """

    problem: str
    measure: str
    quantity: str
    accuracy: float
    found: tuple[Choice, ...]
    quantities: tuple[str, ...]

    @property
    def record(self) -> dict[str, Any]:
        """All of it for JSON."""
        about = {name: getattr(self, name) for name in ("problem", "measure", "quantity")}
        accuracy = self.accuracy if isfinite(self.accuracy) else None
        return {**about, "accuracy": accuracy, "schemes": [one.record for one in self.found]}


def curves(rows: Iterable[VerdictRow], levels: Iterable[Row], details: Iterable[Row]) -> list[Curve]:
    """Return the errors of all rows of measures of errors.

    Parameters
    ----------
    rows : iterable of VerdictRow
    levels, details : iterable of mapping
        Rows of the levels, and of the details of all measures.
    """
    of_levels = grouped(levels, key_of)
    times = {key_of(row): number(row, "step_seconds") for row in details}
    wanted = (row for row in rows if row.measure in ERRORS)
    return [Curve(row, tuple(_points(of_levels.get(row.key, ()))), times.get(row.key, nan)) for row in wanted]


def _points(levels: Iterable[Row]) -> Iterator[tuple[float, float]]:
    for level in levels:
        n, error, spread = (number(level, name) for name in ("steps", "estimate", "std_error"))
        if isfinite(n) and isfinite(error) and abs(error) > CLEAR * (spread if isfinite(spread) else 0.0):
            yield n, abs(error)


def choices(
    found: Sequence[Curve], problem: str, asked: tuple[str, str], noise: Mapping[str, str], accuracy: float = nan
) -> Choices:
    """Return the schemes for a quantity of a problem.

    Parameters
    ----------
    found : sequence of Curve
    problem : str
        Label.
    asked : tuple of str
        Names of measure and quantity; the first quantity there is where that is empty.
    noise : mapping of str to str
        What schemes need, by label.
    accuracy : float, optional
        The error that is wanted; if left out, what half of the schemes reach within the steps of the run.

    Raises
    ------
    UsageError
        If nothing was measured of it.
    """
    measure, quantity = asked
    here = [each for each in found if (each.row.problem, each.row.measure) == (problem, measure)]
    quantities = list(dict.fromkeys(each.row.quantity for each in here if each.row.quantity))
    if not quantities or (quantity and quantity not in quantities):
        known = f"; there are {', '.join(quantities)}" if quantities else ""
        raise UsageError(
            f"nothing to choose from: no {measure} error of {quantity or 'anything'} on {problem}{known}"
        )
    name = quantity or quantities[0]
    own = [each for each in here if each.row.quantity in {name, ""}]
    reached = [each.points[-1][1] for each in own if each.points]
    wanted = accuracy if isfinite(accuracy) else _one_digit_up(median(reached)) if reached else nan
    made = [_choice(each, noise.get(each.row.scheme, ""), wanted) for each in own]
    by_work = sorted(made, key=lambda one: (not isfinite(one.seconds), one.seconds, one.scheme))
    return Choices(problem, measure, name, wanted, tuple(by_work), tuple(quantities))


def _one_digit_up(value: float) -> float:
    unit = 10.0 ** floor(log10(value))
    return float(f"{ceil(value / unit) * unit:.1g}")


def _choice(curve: Curve, noise: str, accuracy: float) -> Choice:
    row, order = curve.row, known_order(curve.row)[0].value
    error = curve.points[-1][1] if curve.points else nan
    steps, beyond = _steps(curve.points, accuracy, order)
    seconds = steps * curve.step_seconds
    return Choice(row.scheme, row.verdict, row.claim, order, noise, error, steps, seconds, beyond)


def _steps(points: Sequence[tuple[float, float]], accuracy: float, order: float) -> tuple[float, bool]:
    """Return the number of steps from which on errors are below an accuracy, and whether it is beyond the finest."""
    if not points or not isfinite(accuracy):
        return nan, False
    first = next((i for i in range(len(points)) if all(e <= accuracy for _, e in points[i:])), len(points))
    if first == 0:
        return points[0][0], False
    n, error = points[first - 1]
    if first == len(points):
        known = isfinite(order) and order > 0.0 and log2(error / accuracy) <= order * log2(FARTHEST)
        return (float(ceil(n * (error / accuracy) ** (1.0 / order))), True) if known else (nan, False)
    finer, smaller = points[first]
    slope = log2(error / smaller) / log2(finer / n)
    return float(ceil(n * (error / accuracy) ** (1.0 / slope))), False
