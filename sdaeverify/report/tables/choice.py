"""Choice of a scheme for a problem by the work for an accuracy, from the errors and times of a run.

With errors e(n) at numbers of steps n, the number of steps for an accuracy is found by linear interpolation of log e
against log n. Beyond the finest level the line is extrapolated with the order along paths, for up to six levels. The
work is the measured time of these steps on a path. Only errors clear of their noise are used.

Errors of schemes are comparable if they refer to one reference, as in `common_errors`. The levels of a finished run
hold errors with respect to a scheme's own limit if no solution is known; then only verified schemes are compared,
whose limit is the solution. Schemes with a refuted claim, and negative controls of the problem without a claim, are
left out.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from html import escape
from math import ceil, floor, isfinite, log2, log10, nan
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from ...contracts.settings import Settings
from ...contracts.specs import built
from ...errors import UsageError
from ...measures.path_errors.errors import STATE
from ...study import CellResult
from ..cells import Row, grouped, number
from ..folders import key_of
from ..pictures import AXES, CLEAR, known_order
from ..verdict_row import VerdictRow
from .common_errors import OF_MEANS, Show, common_errors

if TYPE_CHECKING:
    import pandas as pd

# Measures whose levels are errors along paths that decrease with more steps, and the measure of stationary means,
# whose steps are counted per unit of time.
ALONG_PATHS = tuple(measure for measure, axis in AXES.items() if axis.paid_by_steps)
STATIONARY = "invariant"
ERRORS = (*ALONG_PATHS, STATIONARY)
VERIFIED, REFUTED = "verified", frozenset({"refuted", "diverged"})
# Largest extrapolation, as a multiple of the steps of the finest level: six levels.
FARTHEST = 64


@dataclass(frozen=True)
class Choice:
    """Work of a scheme for an accuracy.

    Attributes
    ----------
    scheme, verdict, claim : str
        Label of the scheme, its verdict and its claim.
    order : float
        Order along paths, or of one step if paths give none.
    noise : str
        Random variables that the scheme needs.
    error : float
        Error at the finest step size that is used.
    at : float
        Number of steps there, on a path or, for stationary means, per unit of time.
    steps : float
        Number of steps for the accuracy; NaN if unknown.
    seconds : float
        Measured time of these steps on a path.
    beyond : bool
        Whether `steps` is extrapolated by the order, or taken from the leading error: no level is as accurate.
    leading : str
        The leading error in words, such as ``-0.184 h``; empty if it is not known without sampling.
    """

    scheme: str
    verdict: str
    claim: str
    order: float
    noise: str
    error: float
    at: float = nan
    steps: float = nan
    seconds: float = nan
    beyond: bool = False
    leading: str = ""

    @property
    def record(self) -> dict[str, Any]:
        """Fields for JSON, in which numbers that are not finite are null."""
        numbers = ((name, value) for name, value in asdict(self).items())
        return {name: None if isinstance(value, float) and not isfinite(value) else value for name, value in numbers}


class CommonBasis(NamedTuple):
    """Errors and times on which schemes are compared.

    Attributes
    ----------
    reference : str
        As in `Choices`; empty if errors and times are those of the run.
    errors : mapping of str to sequence of (int, float, float)
        Number of steps, error and standard error of the requested quantity by scheme, if there is a reference.
    step_seconds : mapping of str to float
        Time of a step by scheme, on arrays of the same size.
    negative : frozenset of str
        Negative controls of the problem for the measure.
    """

    reference: str = ""
    errors: Mapping[str, Sequence[tuple[int, float, float]]] = {}
    step_seconds: Mapping[str, float] = {}
    negative: frozenset[str] = frozenset()

    def applied_to(self, curve: "Curve") -> "Curve":
        """Return a curve with comparable errors and times, without errors if they are not comparable."""
        scheme = curve.row.scheme
        points = curve.points if curve.row.verdict == VERIFIED or curve.row.measure == STATIONARY else ()
        if self.reference:
            clear = ((n, error) for n, error, spread in self.errors.get(scheme, ()) if error > CLEAR * spread)
            points = tuple((float(n), error) for n, error in clear if isfinite(error))
        return replace(curve, points=points, step_seconds=self.step_seconds.get(scheme, curve.step_seconds))


OF_THE_RUN = CommonBasis()


class Leading(NamedTuple):
    """The leading error C h^p, where it is known without sampling, and the run it is of.

    Attributes
    ----------
    constant, power : float
        C and p; NaN where they are not known.
    horizon : float
        T = n h.
    coarsest : float
        The least number n of steps of the run.
    """

    constant: float = nan
    power: float = nan
    horizon: float = nan
    coarsest: float = nan

    @classmethod
    def of(cls, details: Row, horizon: float = nan, coarsest: float = nan) -> "Leading":
        """Return the leading error in a row of details.

        Parameters
        ----------
        details : mapping
        horizon : float, optional
            T.
        coarsest : float, optional
            The least number of steps.
        """
        return cls(number(details, "error_constant"), number(details, "error_power"), horizon, coarsest)

    def __str__(self) -> str:
        if not (isfinite(self.constant) and isfinite(self.power)):
            return ""
        return f"{self.constant:.3g} h" + ("" if self.power == 1.0 else f"^{self.power:g}")

    def steps(self, accuracy: float) -> float:
        """Return the number of steps, no fewer than the coarsest one, with which C h^p is an accuracy; or NaN."""
        needed = self.horizon * (abs(self.constant) / accuracy) ** (1.0 / self.power) if str(self) else nan
        return float(ceil(max(needed, self.coarsest))) if isfinite(needed) else nan


UNKNOWN = Leading()


@dataclass(frozen=True)
class Curve:
    """Comparable errors of a scheme, coarsest first, the time of one of its steps, and its leading error."""

    row: VerdictRow
    points: tuple[tuple[float, float], ...]
    step_seconds: float
    leading: Leading = UNKNOWN


@dataclass(frozen=True)
class Choices:
    """Schemes for a quantity of a problem, least work first; those of unknown work come last.

    Attributes
    ----------
    problem, measure, quantity : str
    accuracy : float
    found : tuple of Choice
    quantities : tuple of str
        Quantities of the measure on the problem.
    reference : str
        Reference of the errors, in words; empty for a finished run.
    left_out : tuple of str
        Schemes with a refuted claim, and negative controls.
    """

    problem: str
    measure: str
    quantity: str
    accuracy: float
    found: tuple[Choice, ...]
    quantities: tuple[str, ...]
    reference: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def table(self) -> "pd.DataFrame":
        """Schemes as a table, one row each, in the same order."""
        import pandas as pd  # noqa: PLC0415 - plugins and workers need no tables

        return pd.DataFrame([asdict(one) for one in self.found], columns=[field.name for field in fields(Choice)])

    def _repr_html_(self) -> str:
        size = f" for an error of {self.accuracy:g}" if isfinite(self.accuracy) else ""
        heading = f"{self.problem}: work{size} of {self.measure} {self.quantity}, the least first"
        table = self.table.to_html(index=False, border=0, na_rep="", float_format="{:.3g}".format)
        return f"<p><b>{escape(heading)}</b></p>{table}"

    @property
    def record(self) -> dict[str, Any]:
        """All fields for JSON."""
        about = {name: getattr(self, name) for name in ("problem", "measure", "quantity")}
        accuracy = self.accuracy if isfinite(self.accuracy) else None
        also = {"reference": self.reference, "left_out": [*self.left_out]}
        return {**about, "accuracy": accuracy, **also, "schemes": [one.record for one in self.found]}


def curves(rows: Iterable[VerdictRow], levels: Iterable[Row], details: Iterable[Row]) -> list[Curve]:
    """Return the error curves of all rows of measures of errors.

    Parameters
    ----------
    rows : iterable of VerdictRow
    levels, details : iterable of mapping
        Rows of the levels, and of the details of all measures.
    """
    of_levels = grouped(levels, key_of)
    told = {key_of(row): row for row in details}
    wanted = (row for row in rows if row.measure in ERRORS)
    return [_curve(row, of_levels.get(row.key, ()), told.get(row.key, {})) for row in wanted]


def _curve(row: VerdictRow, levels: Sequence[Row], details: Row) -> Curve:
    known = [(number(level, "steps"), number(level, "h")) for level in levels]
    n, h = min(((n, h) for n, h in known if isfinite(n)), default=(nan, nan))
    return Curve(row, tuple(_points(levels)), number(details, "step_seconds"), Leading.of(details, n * h, n))


def _points(levels: Iterable[Row]) -> Iterator[tuple[float, float]]:
    for level in levels:
        n, error, spread, floor = (number(level, name) for name in ("steps", "estimate", "std_error", "error_floor"))
        if not isfinite(n):
            n = 1.0 / number(level, "h")
        noise = max(CLEAR * spread if isfinite(spread) else 0.0, floor if isfinite(floor) else 0.0)
        if isfinite(n) and isfinite(error) and abs(error) > noise:
            yield n, abs(error)


def choices(
    found: Sequence[Curve],
    problem: str,
    asked: tuple[str, str],
    noise: Mapping[str, str],
    accuracy: float = nan,
    basis: CommonBasis = OF_THE_RUN,
) -> Choices:
    """Rank the schemes for a quantity of a problem by their work; those without a claim come last.

    Parameters
    ----------
    found : sequence of Curve
    problem : str
        Label of the problem.
    asked : tuple of str
        Names of measure and quantity; the first quantity if that name is empty.
    noise : mapping of str to str
        Random variables that the schemes need, by label.
    accuracy : float, optional
        Required error; by default the median of the errors that schemes with a claim reach in the run.
    basis : CommonBasis, optional
        Basis of the comparison; by default the errors and times of the run.

    Raises
    ------
    UsageError
        If no error of the quantity was measured.
    """
    measure, name = asked[0], first_quantity(found, problem, asked)
    here = _of_cells(found, problem, measure)
    own = [basis.applied_to(each) for each in here if each.row.quantity in {name, ""}]
    out = _refuted(here)
    out |= {each.row.scheme for each in own if not each.row.claim} & basis.negative
    own = [each for each in own if each.row.scheme not in out]
    reached = [each.points[-1][1] for each in own if each.points and each.row.claim]
    wanted = accuracy if isfinite(accuracy) else _one_digit_up(median(reached)) if reached else nan
    made = [_choice(each, noise.get(each.row.scheme, ""), wanted) for each in own]
    by_work = sorted(made, key=lambda one: (not one.claim, not isfinite(one.seconds), one.seconds, one.scheme))
    quantities = tuple(_quantities(here))
    return Choices(problem, measure, name, wanted, tuple(by_work), quantities, basis.reference, tuple(sorted(out)))


def _of_cells(found: Sequence[Curve], problem: str, measure: str) -> list[Curve]:
    """Return the curves of one problem and measure."""
    return [each for each in found if (each.row.problem, each.row.measure) == (problem, measure)]


def _refuted(found: Sequence[Curve]) -> set[str]:
    """Return the schemes with a refuted claim."""
    return {each.row.scheme for each in found if each.row.verdict in REFUTED}


def _quantities(found: Sequence[Curve]) -> list[str]:
    """Return the distinct quantities of curves, in order."""
    return list(dict.fromkeys(each.row.quantity for each in found if each.row.quantity))


def first_quantity(found: Sequence[Curve], problem: str, asked: tuple[str, str]) -> str:
    """Return the requested quantity, or the first one.

    Parameters
    ----------
    found : sequence of Curve
    problem : str
        Label of the problem.
    asked : tuple of str
        As in `choices`, which raises the same errors.
    """
    measure, quantity = asked
    quantities = _quantities(_of_cells(found, problem, measure))
    if not quantities or (quantity and quantity not in quantities):
        why = f"sdaeverify matrix -p {problem} -m {measure} --dry-run says why"
        known = f"there are {', '.join(quantities)}" if quantities else why
        of = f" of {quantity}" if quantity else ""
        raise UsageError(f"nothing to choose from: no {measure} error{of} is known on {problem}; {known}")
    if measure == OF_MEANS and quantities == [STATE]:
        what = "the problem has no observables, and weak errors are those of means of observables"
        raise UsageError(f"nothing to choose from on {problem}: {what}; give it some, or take -m strong")
    return quantity or quantities[0]


def best_verified(found: Sequence[Curve], problem: str, asked: tuple[str, str]) -> str:
    """Return the scheme for the common reference: verified, of the highest order, with the least error.

    The result is empty if no scheme is verified in the quantity without a refutation in another one.

    Parameters
    ----------
    found : sequence of Curve
    problem : str
        Label of the problem.
    asked : tuple of str
        As in `choices`, which raises the same errors.
    """
    name, here = first_quantity(found, problem, asked), _of_cells(found, problem, asked[0])
    out = _refuted(here)
    good = [each for each in here if each.row.quantity == name and each.row.verdict == VERIFIED]
    ranked = [
        (-each.row.claimed_order, each.points[-1][1] if each.points else 0.0, each.row.scheme)
        for each in good
        if each.row.scheme not in out
    ]
    return min(ranked)[2] if ranked else ""


def common_basis(
    results: Iterable[CellResult],
    known: Sequence[Curve],
    problem: str,
    asked: tuple[str, str],
    settings: Settings,
    show: Show,
) -> CommonBasis:
    """Compute errors against one reference, and times on arrays of the same size, for the schemes of a problem.

    Parameters
    ----------
    results : iterable of CellResult
        Results of a run in this process; without results, errors and times of the run are used.
    known : sequence of Curve
        Error curves of the run.
    problem : str
        Label of the problem.
    asked : tuple of str
        Names of measure and quantity, as in `choices`.
    settings : Settings
    show : callable, Compared -> None
        Callback for progress.
    """
    here = [one.cell for one in results if (one.cell.spec.label, one.cell.measure.name) == (problem, asked[0])]
    ready = {cell.scheme.label: cell for cell in here if cell.verdict is None and cell.seen is not None}
    if not ready:
        return OF_THE_RUN
    quantity = first_quantity(known, problem, asked) if asked[0] in ALONG_PATHS else ""
    best = ready.get(best_verified(known, problem, asked))
    found = common_errors([*ready.values()], (asked[0], quantity), settings, best, show)
    controls = built(next(iter(ready.values())).spec).controls
    negative = frozenset(control.negative for control in controls if control.measure == asked[0])
    return CommonBasis(found.reference, found.errors, found.step_seconds, negative)


def _one_digit_up(value: float) -> float:
    unit = 10.0 ** floor(log10(value))
    return float(f"{ceil(value / unit) * unit:.1g}")


def _choice(curve: Curve, noise: str, accuracy: float) -> Choice:
    row, order = curve.row, known_order(curve.row)[0].value
    at, error = curve.points[-1] if curve.points else (nan, nan)
    steps, beyond = _steps(curve.points, accuracy, order)
    if not isfinite(steps) and isfinite(accuracy):
        steps = curve.leading.steps(accuracy)
        beyond = isfinite(steps)
    seconds, leading = steps * curve.step_seconds, str(curve.leading)
    return Choice(row.scheme, row.verdict, row.claim, order, noise, error, at, steps, seconds, beyond, leading)


def _steps(points: Sequence[tuple[float, float]], accuracy: float, order: float) -> tuple[float, bool]:
    """Return the number of steps from which errors stay below an accuracy, and whether it is extrapolated."""
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
