"""Time stepping of adaptive solvers that accept or reject steps, with separate steps on each path, vectorised."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from sdaeverify import SDE, Array, Increment

from .contract import Adaptive, Solved, why_not_own_times
from .path import TICKS, Path, Point

# Longest step in ticks.
LONGEST = TICKS // 8
# Safety factor, and least and largest factor between the lengths of consecutive steps.
SAFETY, SHRINK, GROW = 0.9, 0.2, 4.0
# Leading bits of a length in ticks, so that few times lie far below the grid of the path.
BITS = 3


class Front(NamedTuple):
    """State of the integration on each path; arrays with paths last.

    Attributes
    ----------
    x : ndarray, shape (d, P)
    here : Point
    size : ndarray of int, shape (P,)
        Length of the next attempted step, in ticks.
    error : ndarray, shape (P,)
        Error of the last accepted step, relative to the tolerance.
    steps, rejected : ndarray of int, shape (P,)
    """

    x: Array
    here: Point
    size: Array
    error: Array
    steps: Array
    rejected: Array

    @classmethod
    def begin(cls, problem: SDE, path: Path, size: int) -> Self:
        """Create the initial state of the integration.

        Parameters
        ----------
        problem : SDE
            Problem with an initial state.
        path : Path
            Paths to integrate along.
        size : int
            Length of the first step, in ticks.
        """
        ones, none = np.ones(path.paths), np.zeros(path.paths, dtype=np.int64)
        return cls(problem.initial(path.paths), path.at(0), none + size, ones, none, none)

    def only(self, paths: Array) -> "Front":
        """Return a subset of the paths."""
        return Front(*(_taken(part, paths) for part in self))

    def replaced(self, paths: Array, other: "Front") -> "Front":
        """Return a copy with some of the paths taken from another front."""
        return Front(*(_put(part, paths, new) for part, new in zip(self, other, strict=True)))


def _taken(part: Any, paths: Array) -> Any:
    return Point(*(each[..., paths] for each in part)) if isinstance(part, Point) else part[..., paths]


def _put(part: Any, paths: Array, new: Any) -> Any:
    if isinstance(part, Point):
        return Point(*(_put(old, paths, each) for old, each in zip(part, new, strict=True)))
    changed = part.copy()
    changed[..., paths] = new
    return changed


class Stretch(NamedTuple):
    """An attempted step on each path.

    Attributes
    ----------
    path : Path
    x : ndarray, shape (d, P)
        State at the beginning of the step.
    here, there : Point
        Beginning and end of the step.
    """

    path: Path
    x: Array
    here: Point
    there: Point

    @property
    def t(self) -> Array:
        """Times at the beginning of the steps, shape (P,)."""
        return np.asarray(self.here.tick * self.path.tick)

    @property
    def h(self) -> Array:
        """Lengths of the steps, shape (P,)."""
        return np.asarray((self.there.tick - self.here.tick) * self.path.tick)

    @property
    def noise(self) -> Increment:
        """Increments dW and H over the steps."""
        return self.path.between(self.here, self.there)


class Tried(NamedTuple):
    """Result of an attempted step: the new state and the error estimate, both of shape (d, P)."""

    x: Array
    error: Array


@dataclass(frozen=True)
class Marching(Adaptive):
    """Base of solvers that advance step by step: a subclass estimates the error of a step.

    A step is accepted if its error, in the largest norm of the components, is at most tol (1 + |x|); the next one is
    longer by the factor 0.9 e^{-(a + b)} e_-^b with the errors e and e_- of this step and of the one before, between
    0.2 and 4 (a controller with proportional and integral part). No step is longer than T/8.
    """

    evaluations_of_step: ClassVar[int] = 2
    integral: ClassVar[float] = 0.4
    proportional: ClassVar[float] = 0.1
    shortest: ClassVar[int] = 1
    longest: ClassVar[int] = LONGEST

    @abstractmethod
    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions without a derivative, and coefficients that accept no array of times."""
        return problem.why_not_derivative_of_diffusion() or why_not_own_times(problem)

    def solve(self, problem: SDE, path: Path, tolerance: float) -> Solved:
        """Solve a problem on each path up to its horizon."""
        front = Front.begin(problem, path, self.longest)
        passed = [front.here]
        while (left := np.flatnonzero(front.here.tick < TICKS)).size:
            some = self.advance(problem, path.only(left), front.only(left), tolerance)
            front = front.replaced(left, some)
            passed.append(front.here)
        return self.solved(front, passed)

    def solved(self, front: Front, passed: Sequence[Point]) -> Solved:
        """Return the result at the end of the integration."""
        tries = front.steps + front.rejected
        times, W = np.stack([each.tick for each in passed]), np.stack([each.W for each in passed])
        return Solved(front.x, front.steps, front.rejected, self.evaluations_of_step * tries, times, W)

    def advance(self, problem: SDE, path: Path, front: Front, tolerance: float) -> Front:
        """Attempt one step on each path and return the new state of the integration.

        Parameters
        ----------
        problem : SDE
        path : Path
        front : Front
            State of the integration, with no path at the horizon.
        tolerance : float
        """
        there = self.ahead(path, front)
        tried = self.attempt(problem, Stretch(path, front.x, front.here, there))
        error = self.norm(tried, front.x, tolerance)
        accepted = (error <= 1.0) | (there.tick - front.here.tick <= self.shortest)
        taken = Front(tried.x, there, front.size, error, front.steps + 1, front.rejected)
        kept = front._replace(rejected=front.rejected + 1)
        moved = Front(*(_where(accepted, new, old) for new, old in zip(taken, kept, strict=True)))
        return moved._replace(size=self.resized(moved, error, front.error, accepted))

    def ahead(self, path: Path, front: Front) -> Point:
        """Return the end point of the next attempted step."""
        return path.at(np.minimum(front.here.tick + front.size, TICKS))

    def norm(self, tried: Tried, x: Array, tolerance: float) -> Array:
        """Return the error of a step relative to the tolerance, shape (P,), bounded away from 0.

        Parameters
        ----------
        tried : Tried
        x : ndarray, shape (d, P)
            State at the beginning of the step.
        tolerance : float
        """
        scale = tolerance * (1.0 + np.maximum(np.abs(x), np.abs(tried.x)))
        return np.asarray(np.maximum(np.max(np.abs(tried.error) / scale, axis=0), 1e-10))

    def resized(self, moved: Front, error: Array, before: Array, accepted: Array) -> Array:
        """Return the length of the next step in ticks, shape (P,).

        Parameters
        ----------
        moved : Front
            State after the attempted step.
        error, before : ndarray, shape (P,)
            Errors of the attempted step and of the last accepted step before it.
        accepted : ndarray of bool, shape (P,)
        """
        a, b = self.integral, self.proportional
        factor = SAFETY * error ** -(a + b) * np.where(accepted, before, 1.0) ** b
        factor = np.clip(factor, SHRINK, np.where(accepted, GROW, SAFETY))
        return rounded(np.clip(moved.size * factor, self.shortest, self.longest))


def _where(accepted: Array, new: Any, old: Any) -> Any:
    if isinstance(new, Point):
        return Point(*(_where(accepted, a, b) for a, b in zip(new, old, strict=True)))
    return np.where(accepted, new, old)


def rounded(size: Array) -> Array:
    """Round lengths down to whole ticks with at most four leading bits."""
    whole = size.astype(np.int64)
    unit = 2 ** np.maximum(np.frexp(whole.astype(float))[1] - 1 - BITS, 0).astype(np.int64)
    return np.asarray(whole // unit * unit)


def powers(size: Array) -> Array:
    """Round lengths down to powers of 2, at least one tick."""
    return np.asarray(2 ** (np.frexp(np.maximum(size, 1.0))[1] - 1).astype(np.int64))
