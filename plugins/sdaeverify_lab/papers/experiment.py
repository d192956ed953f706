"""An experiment of a paper: runs as data, and a pure function from the evidence to a table and to curves."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sdaeverify import Array, Parts, Problem, ProblemError, Scheme

from .exhibit import Exhibit

if TYPE_CHECKING:
    from .run import ExperimentEvidence

# Reductions of the values of a note over several steps.
EACH, MEAN, MAX = "each", "mean", "max"
REDUCTIONS = (EACH, MEAN, MAX)


class Budget(StrEnum):
    """Budget of an experiment: seconds, or that of the numbers in the documentation."""

    SMOKE = "smoke"
    FULL = "full"


class SharedNoise(NamedTuple):
    """A Brownian motion that drives runs on different problems.

    Attributes
    ----------
    name : str
        Name; runs with the same name share their paths.
    dimension : int
        Number of Brownian motions.
    """

    name: str
    dimension: int


@dataclass(frozen=True)
class Note:
    """A quantity recorded along every path.

    Attributes
    ----------
    name : str
    of : str or callable, (problem, t, parts) -> ndarray, shape (..., P)
        Name of one of the problem's observables, or a function at the top level of a module, or an instance of a
        dataclass with ``__call__``, because it is sent to worker processes.
    at : sequence of int or None
        Steps after which the quantity is recorded, possibly a range; by default after the last.
    over : str
        Reduction over these steps: ``each``, ``mean`` or ``max``.
    """

    name: str
    of: str | Callable[[Problem, float, Parts], Array]
    at: Sequence[int] | None = None
    over: str = EACH

    def __post_init__(self) -> None:
        if self.over not in REDUCTIONS:
            raise ProblemError(f"over must be one of {', '.join(REDUCTIONS)}, got {self.over!r}")
        if self.at is not None and (not self.at or min(self.at) < 1):
            raise ProblemError(f"note {self.name!r} must be taken after steps from 1 on, got {self.at!r}")

    def steps(self, last: int) -> Sequence[int]:
        """Return the steps after which the quantity is recorded, for a run of `last` steps."""
        return (last,) if self.at is None else self.at


@dataclass(frozen=True)
class SchemeRun:
    """Paths of a scheme with one step size.

    Attributes
    ----------
    problem, scheme : str
        Labels of a registered problem and scheme.
    steps : int
        Number of steps up to the final time; for runs on one noise, the least one times powers of 2.
    notes : tuple of Note
    noise : SharedNoise or None
        Driving noise; by default a Brownian motion shared by all runs on this problem.
    drive : callable, ndarray of shape (steps, dimension, P) -> ndarray of shape (steps, l, P), optional
        Linear map from the increments of `noise` to those of the problem; by default the identity.
    """

    problem: str
    scheme: str
    steps: int
    notes: tuple[Note, ...] = ()
    noise: SharedNoise | None = None
    drive: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise ProblemError(f"a run needs at least 1 step, got {self.steps}")
        for note in self.notes:
            if max(note.steps(self.steps)) > self.steps:
                raise ProblemError(f"note {note.name!r} must be taken after 1 to {self.steps} steps, got {note.at!r}")


@dataclass(frozen=True)
class Probe:
    """A computation without paths.

    Attributes
    ----------
    of : callable, (problems, schemes) -> mapping of str to ndarray
        Function at the top level of a module, or instance of a dataclass with ``__call__``.
    problems, schemes : tuple of str
        Labels of its arguments.
    """

    of: Callable[[tuple[Problem, ...], tuple[Scheme, ...]], Mapping[str, Array]]
    problems: tuple[str, ...] = ()
    schemes: tuple[str, ...] = ()


Work = Mapping[Hashable, SchemeRun | Probe]


class Noted(NamedTuple):
    """Recorded values of a note.

    Attributes
    ----------
    values : ndarray, shape (times, ..., P)
        Values, NaN on lost paths; a single time for ``mean`` and ``max``.
    without_root, lost : ndarray of bool, shape (times, P)
        Whether a step found no root on a path, and whether the path is not finite or blew up, up to this time.
    at : tuple of int
        Steps after which the values were recorded.
    error : str
        Why there are no values; empty otherwise.
    """

    values: Array = np.zeros((1, 0))
    without_root: Array = np.zeros((1, 0), dtype=bool)
    lost: Array = np.zeros((1, 0), dtype=bool)
    at: tuple[int, ...] = ()
    error: str = ""

    @property
    def last(self) -> Array:
        """Values at the last time, shape (..., P)."""
        last: Array = self.values[-1]
        return last


class RunFound(NamedTuple):
    """Results of a run.

    Attributes
    ----------
    h : float
        Step size.
    noted : mapping of str to Noted
    costs : mapping of str to ndarray, shape (blocks, 2)
        For each block, the sum of a cost over steps and paths, and the number of summands.
    paths : int
    error : str
        Why there are no results; empty otherwise.
    """

    h: float = np.nan
    noted: Mapping[str, Noted] = {}
    costs: Mapping[str, Array] = {}
    paths: int = 0
    error: str = ""


class ProbeFound(NamedTuple):
    """Results of a probe: arrays by name, or the error."""

    values: Mapping[str, Array] = {}
    error: str = ""


class SchemeMean(NamedTuple):
    """Mean of a scheme without sampling; NaN if unknown.

    Attributes
    ----------
    value : float
    factor : float
        Asymptotic growth factor of second moments per step.
    rate : float
        Growth rate of the equation's second moments, e^(rate t).
    """

    value: float = np.nan
    factor: float = np.nan
    rate: float = np.nan


class SchemeValue(NamedTuple):
    """An observable after `at` of `steps` steps of a scheme."""

    scheme: str
    steps: int
    observable: str
    at: int


class Experiment(ABC):
    """A table or figure of a paper: a subclass sets the attributes and defines runs and results.

    Attributes
    ----------
    name : str
        Registered name, ``author-year-figure-1``.
    title : str
        Contents in one line.
    source : str
    paths, full_paths : int
        Default numbers of trajectories of every run at the two budgets; by default equal.
    block : int
        Number of trajectories that are simulated together, on which the noise depends.
    notes : tuple of str
        Notes for readers of the table.
    """

    name: str
    title: str
    source: str
    paths: int = 1000
    full_paths: int | None = None
    block: int = 500
    notes: tuple[str, ...] = ()

    def paths_of(self, budget: Budget) -> int:
        """Return the number of paths of a budget."""
        return self.full_paths if budget is Budget.FULL and self.full_paths else self.paths

    @abstractmethod
    def work(self, budget: Budget) -> Work:
        """Return the runs and probes, each under a key of the experiment."""

    @abstractmethod
    def exhibit(self, evidence: "ExperimentEvidence") -> Exhibit:
        """Return the table and the curves: a pure function of the evidence."""
