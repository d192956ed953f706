"""What comes of an experiment: entries of a table, and panels of curves, in no library's terms."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from math import hypot, isfinite, nan
from typing import NamedTuple

from sdaeverify import Array, ProblemError

# Two numbers agree that differ by no more than four standard errors, and half a unit of what is printed: by chance
# they disagree once in 16000 times.
STANDARD_ERRORS = 4.0
AGREES, DISAGREES, FEW = "agrees", "disagrees", "void"
# With fewer effective paths a comparison is void, whatever it gives: mean and standard error rest on the same few.
FEWEST_EFFECTIVE = 30.0


@dataclass(frozen=True)
class Printed:
    """A number as a paper prints it.

    Attributes
    ----------
    digits : str
        The number with the paper's digits.
    paths : int
        Trajectories it was taken from; 1 for what is no mean.
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
        """The number."""
        return float(self.digits)

    @property
    def half_unit(self) -> float:
        """Half a unit of the last digit: how far a number can be that is printed like this."""
        exponent = Decimal(self.digits).as_tuple().exponent
        return 0.5 * 10.0 ** int(exponent)


@dataclass(frozen=True)
class TableEntry:
    """A number of a table: ours with its error, the printed and the exact one.

    Attributes
    ----------
    group : str
        What it has in common with the entries around it: a heading.
    at : mapping of str to object
        Where it stands in its group: texts and numbers, a column each.
    value, std_error : float
        Ours; NaN where there is none.
    paths : int
    effective : float
        (sum y)^2/sum y^2, the number of equal paths whose mean would be known as well; NaN if it does not matter.
    printed : Printed or None
    printed_std_error : float
    exact : float
    exact_source : str
    expected : float
        What the scheme's value is without sampling; NaN where it is not known.
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
        """The printed number minus ours."""
        return self.printed.value - self.value if self.printed else nan

    @property
    def print_to_exact(self) -> float:
        """The printed number minus the exact one."""
        return self.printed.value - self.exact if self.printed else nan

    @property
    def print_and_value(self) -> str:
        """Whether the print agrees with our number: both have a sampling error."""
        return self._compare(self.print_to_value, hypot(self.printed_std_error, self.std_error))

    @property
    def print_and_exact(self) -> str:
        """Whether the print agrees with the exact number: only the print has a sampling error."""
        return self._compare(self.print_to_exact, self.printed_std_error)

    @property
    def value_and_expected(self) -> str:
        """Whether our number is the scheme's own: it is not where paths that are too rare to be drawn carry it."""
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
        """Return the row of the file: numbers with all their digits."""
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
    """A line of a panel.

    Attributes
    ----------
    label : str
        Empty for what the legend leaves out.
    x, y : ndarray, shape (k,)
    low, high : ndarray, shape (k,), or None
        Ends of the error bars, or of the band where `kind` is ``band``.
    kind : str
        ``points`` with a line between them, ``marks`` without, ``line``, ``band``, ``guide`` for what is only to be
        compared with, ``printed``.
    hue : int or None
        Curves with the same hue have the same colour; the next one if left out.
    """

    label: str
    x: Array
    y: Array
    low: Array | None = None
    high: Array | None = None
    kind: str = "points"
    hue: int | None = None


class Range(NamedTuple):
    """A shaded part of the x axis.

    Attributes
    ----------
    low, high : float
        Its ends.
    label : str
        What is said of it.
    """

    low: float
    high: float
    label: str


class Panel(NamedTuple):
    """One system of axes.

    Attributes
    ----------
    title, x, y : str
        With the units.
    curves : tuple of Curve
    log : str
        Which axes are logarithmic: a part of ``xy``.
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
    """What comes of an experiment.

    Attributes
    ----------
    entries : tuple of TableEntry
    panels : tuple of Panel
    remarks : tuple of str
        What was found beside the table, a sentence each.
    errors : tuple of str
        What could not be measured, and why.
    """

    entries: tuple[TableEntry, ...]
    panels: tuple[Panel, ...] = ()
    remarks: tuple[str, ...] = ()
    errors: tuple[str, ...] = ()
