"""An experiment of a paper as data: which means of which schemes it printed, so that anybody can take them again."""

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import NamedTuple

from ..errors import ProblemError


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


class FineRun(NamedTuple):
    """What a row is compared with path by path: a run with shorter steps on the same Brownian paths.

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
        What the paper has for it.
    costly : bool
        Whether the row is left out unless all are asked for.
    at : int or None
        After how many of the steps the mean is taken; after all if left out.
    reference : FineRun or None
        With phi the observable of a path, the row is E (phi - phi_reference)^2 if there is one, and E phi if not.
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
        if self.reference and (self.reference.steps <= self.steps or not _doubled(self.reference.steps, self.steps)):
            raise ProblemError(
                f"steps of a reference must be {self.steps} times a power of 2, got {self.reference.steps}"
            )

    @property
    def steps_made(self) -> int:
        """After how many of the steps the mean is taken."""
        return self.steps if self.at is None else self.at

    @property
    def runs(self) -> tuple[int, ...]:
        """Numbers of steps of all runs it is taken from."""
        return (self.steps, self.reference.steps) if self.reference else (self.steps,)


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A table or figure of a paper.

    All rows of a problem run on the same Brownian paths. A row's exact value is the moment that the problem knows at
    the row's time.

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
    block : int
        Trajectories that are simulated together; part of what determines the noise.
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
    block: int = 500
    equilibrium: bool = False
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.rows:
            raise ProblemError(f"experiment {self.name!r} has no rows")
        if self.block < 1:
            raise ProblemError(f"experiment {self.name!r}: a block needs at least 1 path, got {self.block}")
        for problem in dict.fromkeys(row.problem for row in self.rows):
            steps = [count for row in self.rows if row.problem == problem for count in row.runs]
            if not all(_doubled(count, min(steps)) for count in steps):
                raise ProblemError(
                    f"experiment {self.name!r}: steps on {problem} must be the least times powers of 2, got {steps}"
                )


def _doubled(steps: int, least: int) -> bool:
    return steps % least == 0 and (steps // least).bit_count() == 1
