"""An experiment of a paper: what is run, as data, and a pure function from the evidence to a table and to curves."""

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

# How the values of a note at several steps are put together.
EACH, MEAN, MAX = "each", "mean", "max"
REDUCTIONS = (EACH, MEAN, MAX)


class Budget(StrEnum):
    """How much an experiment may cost: seconds, or what the numbers of a document are measured with."""

    SMOKE = "smoke"
    FULL = "full"


class SharedNoise(NamedTuple):
    """A Brownian motion that drives runs on different problems.

    Attributes
    ----------
    name : str
        Runs with the same name share their paths.
    dimension : int
        Number of Brownian motions.
    """

    name: str
    dimension: int


@dataclass(frozen=True)
class Note:
    """What is noted of every path on the way.

    Attributes
    ----------
    name : str
    of : str or callable, (problem, t, parts) -> ndarray, shape (..., P)
        Name of one of the problem's observables, or a function at the top level of a module, or an instance of a
        dataclass with ``__call__``: it is sent to worker processes.
    at : sequence of int or None
        Steps after which it is noted, a range for many; after the last if left out.
    over : str
        What is kept of these: ``each``, their ``mean`` or their ``max``.
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
        """Return the steps after which it is noted in a run of so many steps."""
        return (last,) if self.at is None else self.at


@dataclass(frozen=True)
class SchemeRun:
    """Paths of a scheme with one step size.

    Attributes
    ----------
    problem, scheme : str
        Labels of a registered problem and scheme.
    steps : int
        Number of steps up to the final time. On one noise the numbers are the least one times powers of 2.
    notes : tuple of Note
    noise : SharedNoise or None
        What drives it; a Brownian motion that all runs on this problem share, if left out.
    drive : callable, ndarray of shape (steps, dimension, P) -> ndarray of shape (steps, l, P), optional
        The linear map from the increments of `noise` to those of the problem; the identity if left out.
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
    """Numbers that need no paths.

    Attributes
    ----------
    of : callable, (problems, schemes) -> mapping of str to ndarray
        A function at the top level of a module, or an instance of a dataclass with ``__call__``.
    problems, schemes : tuple of str
        Labels of what it is given.
    """

    of: Callable[[tuple[Problem, ...], tuple[Scheme, ...]], Mapping[str, Array]]
    problems: tuple[str, ...] = ()
    schemes: tuple[str, ...] = ()


Work = Mapping[Hashable, SchemeRun | Probe]


class Noted(NamedTuple):
    """What a note has become.

    Attributes
    ----------
    values : ndarray, shape (times, ..., P)
        NaN on paths that are lost; one time where they are put together.
    without_root, lost : ndarray of bool, shape (times, P)
        Paths on which a step found no root, and which are not finite or blew up, up to this time.
    at : tuple of int
        After which steps.
    error : str
        Why there is nothing; empty if there is.
    """

    values: Array = np.zeros((1, 0))
    without_root: Array = np.zeros((1, 0), dtype=bool)
    lost: Array = np.zeros((1, 0), dtype=bool)
    at: tuple[int, ...] = ()
    error: str = ""

    @property
    def last(self) -> Array:
        """The values at the last time, shape (..., P)."""
        last: Array = self.values[-1]
        return last


class RunFound(NamedTuple):
    """What came of a run.

    Attributes
    ----------
    h : float
        Step size.
    noted : mapping of str to Noted
    costs : mapping of str to ndarray, shape (blocks, 2)
        Of each block, the sum of a cost over steps and paths, and over how many of these.
    paths : int
    error : str
        Why there is nothing; empty if there is.
    """

    h: float = np.nan
    noted: Mapping[str, Noted] = {}
    costs: Mapping[str, Array] = {}
    paths: int = 0
    error: str = ""


class ProbeFound(NamedTuple):
    """What came of a probe: arrays by name, or why there are none."""

    values: Mapping[str, Array] = {}
    error: str = ""


class SchemeMean(NamedTuple):
    """What a scheme's own mean is, without sampling; NaN where it is not known.

    Attributes
    ----------
    value : float
    factor : float
        By which second moments change in a step, in the long run.
    rate : float
        Of the equation's second moments, as e^(rate t).
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
    """A table or figure of a paper: a subclass sets the attributes and says what is run and shown.

    Attributes
    ----------
    name : str
        Registered name, ``author-year-figure-1``.
    title : str
        What it shows, in one line.
    source : str
    paths, full_paths : int
        Trajectories of every run at the two budgets, if nothing else is asked for; as many if left out.
    block : int
        Trajectories that are simulated together; part of what determines the noise.
    notes : tuple of str
        What a reader of the table has to know.
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
        """Return what is run, each under a key of the experiment's own."""

    @abstractmethod
    def exhibit(self, evidence: "ExperimentEvidence") -> Exhibit:
        """Return the table and the curves: a pure function of the evidence."""
