"""Results of an experiment: table entries and panels of curves, independent of a plotting library."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from math import hypot, isfinite, nan
from typing import NamedTuple

from sdaeverify import Array, ProblemError

# Numbers agree if they differ by at most this many standard errors plus half a unit of the last printed digit; by
# chance they disagree once in 16000 times.
STANDARD_ERRORS = 4.0
AGREES, DISAGREES, FEW = "agrees", "disagrees", "void"
# Least number of effective paths for a meaningful standard error; a comparison with fewer is void.
FEWEST_EFFECTIVE = 30.0


@dataclass(frozen=True)
class Printed:
    """A number printed in a paper.

    Attributes
    ----------
    digits : str
        The number with the digits of the paper.
    paths : int
        Number of trajectories of a mean; 1 for other numbers.
    """

    digits: str
    paths: int = 1

    def __post_init__(self) -> None:
        try:
            finite = Decimal(self.digits).is_finite()
        except InvalidOperation:
            finite = False
        if not finite:
            raise ProblemError(f"a printed number must be a number, got {self.digits!r}")
        if self.paths < 1:
            raise ProblemError(f"a printed mean is taken from at least 1 trajectory, got {self.paths!r}")

    @property
    def value(self) -> float:
        """The number as a float."""
        return float(self.digits)

    @property
    def half_unit(self) -> float:
        """Half a unit of the last digit, the largest rounding error of the printed number."""
        exponent = Decimal(self.digits).as_tuple().exponent
        return 0.5 * 10.0 ** int(exponent)


@dataclass(frozen=True)
class TableEntry:
    """A number of a table: the computed value with its error, the printed and the exact one.

    Attributes
    ----------
    group : str
        Heading of the group of entries.
    at : mapping of str to object
        Texts and numbers that identify the entry in its group, one column each.
    value, std_error : float
        Computed value and its standard error; NaN if there is none.
    paths : int
    effective : float
        Effective sample size (sum y)^2/sum y^2; NaN if irrelevant.
    printed : Printed or None
    printed_std_error : float
    exact : float
    exact_source : str
    expected : float
        Value of the scheme without sampling error; NaN if unknown.
    more : mapping of str to object
        Further columns of the file.
    """

    group: str
    at: Mapping[str, object]
    value: float = nan
    std_error: float = 0.0
    paths: int = 0
    effective: float = nan
    printed: Printed | None = None
    printed_std_error: float = 0.0
    exact: float = nan
    exact_source: str = ""
    expected: float = nan
    more: Mapping[str, object] = field(default_factory=dict)

    @property
    def print_to_value(self) -> float:
        """Printed number minus the computed one."""
        return self.printed.value - self.value if self.printed else nan

    @property
    def print_to_exact(self) -> float:
        """Printed number minus the exact one."""
        return self.printed.value - self.exact if self.printed else nan

    @property
    def print_and_value(self) -> str:
        """Agreement of the printed with the computed number, both of which have sampling errors."""
        return self._compare(self.print_to_value, hypot(self.printed_std_error, self.std_error))

    @property
    def print_and_exact(self) -> str:
        """Agreement of the printed with the exact number, where only the former has a sampling error."""
        return self._compare(self.print_to_exact, self.printed_std_error)

    @property
    def value_and_expected(self) -> str:
        """Agreement of the computed number with the value of the scheme without sampling.

        Both values disagree if paths too rare to be drawn dominate the mean.
        """
        return self._agreement(self.value - self.expected, STANDARD_ERRORS * self.std_error)

    def _compare(self, difference: float, std_error: float) -> str:
        half_unit = self.printed.half_unit if self.printed else nan
        return self._agreement(difference, half_unit + STANDARD_ERRORS * std_error)

    def _agreement(self, difference: float, allowed: float) -> str:
        if not isfinite(difference) or not isfinite(allowed):
            return ""
        if self.std_error > 0.0 and self.effective < FEWEST_EFFECTIVE:
            return FEW
        return DISAGREES if abs(difference) > allowed else AGREES

    def record(self) -> dict[str, object]:
        """Return the row of the file, numbers with all digits."""
        printed = self.printed
        return {
            "group": self.group,
            **self.at,
            "value": self.value,
            "std_error": self.std_error,
            "paths": self.paths,
            "effective_paths": self.effective,
            "expected": self.expected,
            "value_minus_expected": self.value - self.expected,
            "value_and_expected": self.value_and_expected,
            "exact": self.exact,
            "exact_source": self.exact_source,
            "value_minus_exact": self.value - self.exact,
            "printed": printed.digits if printed else "",
            "printed_paths": printed.paths if printed else "",
            "printed_std_error": self.printed_std_error if printed else nan,
            "printed_minus_value": self.print_to_value,
            "printed_and_value": self.print_and_value,
            "printed_minus_exact": self.print_to_exact,
            "printed_and_exact": self.print_and_exact,
            **self.more,
        }


class Curve(NamedTuple):
    """A curve of a panel.

    Attributes
    ----------
    label : str
        Label in the legend; empty to omit the curve.
    x, y : ndarray, shape (k,)
    low, high : ndarray, shape (k,), or None
        Ends of the error bars, or of the band if `kind` is ``band``.
    kind : str
        ``points`` with a line between them, ``marks`` without a line, ``line``, ``band``, ``guide`` for a reference
        line, ``printed``.
    hue : int or None
        Index of the colour; by default the next one.
    """

    label: str
    x: Array
    y: Array
    low: Array | None = None
    high: Array | None = None
    kind: str = "points"
    hue: int | None = None


class Range(NamedTuple):
    """A shaded range of the x axis.

    Attributes
    ----------
    low, high : float
        Ends of the range.
    label : str
        Label of the range.
    """

    low: float
    high: float
    label: str


class Panel(NamedTuple):
    """One system of axes.

    Attributes
    ----------
    title, x, y : str
        Title and axis labels, with units.
    curves : tuple of Curve
    log : str
        Logarithmic axes, a part of ``xy``.
    ranges : tuple of Range
    equal : bool
        Whether both axes have the same unit.
    """

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    log: str = ""
    ranges: tuple[Range, ...] = ()
    equal: bool = False


class Exhibit(NamedTuple):
    """Results of an experiment.

    Attributes
    ----------
    entries : tuple of TableEntry
    panels : tuple of Panel
    remarks : tuple of str
        Further results in sentences.
    errors : tuple of str
        Quantities that could not be measured, and reasons.
    """

    entries: tuple[TableEntry, ...]
    panels: tuple[Panel, ...] = ()
    remarks: tuple[str, ...] = ()
    errors: tuple[str, ...] = ()
