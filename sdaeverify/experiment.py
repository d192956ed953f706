"""An experiment of a paper as data: which means of which schemes it printed, so that anybody can take them again."""

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

from .errors import ProblemError


@dataclass(frozen=True)
class Printed:
    """A sample mean as a paper prints it.

    Attributes
    ----------
    digits : str
        The number with the paper's digits.
    paths : int
        Trajectories it was taken from.
    """

    digits: str
    paths: int

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


@dataclass(frozen=True, kw_only=True)
class Row:
    """The mean of an observable at the final time.

    Attributes
    ----------
    problem, scheme : str
        Labels of a registered problem and scheme.
    steps : int
        Number of steps up to the final time.
    observable : str
        Name of one of the problem's observables.
    printed : Printed or None
        What the paper has for it.
    costly : bool
        Whether the row is left out unless all are asked for.
    """

    problem: str
    scheme: str
    steps: int
    observable: str
    printed: Printed | None = None
    costly: bool = False


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A table or figure of a paper.

    All rows of a problem run on the same Brownian paths. A row's exact value is the moment that the problem knows at
    the final time.

    Attributes
    ----------
    name : str
        Registered name, ``author-year-table-1``.
    title : str
        What it shows, in one line.
    source : str
    rows : tuple of Row
        The step numbers of one problem are the least one times powers of 2.
    paths : int
        Trajectories of every row, if nothing else is asked for.
    equilibrium : bool
        Whether the final time is so late that means are those of the invariant law, to all digits.
    notes : tuple of str
        What a reader of the table has to know.
    """

    name: str
    title: str
    source: str
    rows: tuple[Row, ...]
    paths: int = 1000
    equilibrium: bool = False
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.rows:
            raise ProblemError(f"experiment {self.name!r} has no rows")
        for problem in dict.fromkeys(row.problem for row in self.rows):
            steps = [row.steps for row in self.rows if row.problem == problem]
            if min(steps) < 1 or not all(_doubled(count, min(steps)) for count in steps):
                raise ProblemError(
                    f"experiment {self.name!r}: steps on {problem} must be the least times powers of 2, got {steps}"
                )


def _doubled(steps: int, least: int) -> bool:
    return steps % least == 0 and (steps // least).bit_count() == 1
