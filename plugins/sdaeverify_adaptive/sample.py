"""The sample: a solver's final states at several tolerances, and the truth, on the same paths."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme, SchemeError, Settings, UsageError
from sdaeverify.numerics import GROUPS
from sdaeverify.studying import Source

from .contract import Adaptive, Solved
from .path import GRID, TICKS, Path, between, brownian_path

# Number of paths that are solved at once, a multiple of the number of groups.
BLOCK = 400
# Number of steps of an exact truth.
EXACT = 2**10
# Least mean number of steps for a tolerance to be used for a rate.
FEWEST_STEPS = 16


@dataclass(frozen=True)
class Budget:
    """Sample size and tolerances.

    Attributes
    ----------
    paths : int
    tolerances : tuple of float
        Tolerances, largest first; by default those of the solver.
    seed : int
    """

    paths: int = 800
    tolerances: tuple[float, ...] = ()
    seed: int = 20170601

    def __post_init__(self) -> None:
        if self.paths < 2 * GROUPS or self.paths % GROUPS:
            raise UsageError(
                f"the number of paths must be a multiple of {GROUPS}, at least {2 * GROUPS}, got {self.paths}"
            )
        falling = all(a > b > 0.0 for a, b in zip(self.tolerances, self.tolerances[1:], strict=False))
        if self.tolerances and (len(self.tolerances) < 3 or not falling):
            given = ",".join(f"{tolerance:g}" for tolerance in self.tolerances)
            raise UsageError(f"a rate needs at least three decreasing positive tolerances, got {given}")
        # Checked before any problem is solved.
        Settings(seed=self.seed)

    def sources(self, label: str) -> Iterator[Source]:
        """Yield the addresses of all blocks of paths; a run smaller than one block draws a block of its size."""
        size = min(BLOCK, self.paths)
        for block, done in enumerate(range(0, self.paths, BLOCK)):
            yield Source(self.seed, label, block, size, min(size, self.paths - done))


class Runs(NamedTuple):
    """Final states at several tolerances or numbers of steps, with numbers of steps and evaluations.

    Attributes
    ----------
    ends : ndarray, shape (K, d, P)
    steps, rejected, evaluations : ndarray, shape (K, P)
    """

    ends: Array
    steps: Array
    rejected: Array
    evaluations: Array

    @classmethod
    def of(cls, solved: Sequence[Solved]) -> Self:
        """Combine runs on the same paths."""
        return cls(*(np.stack(part) for part in list(zip(*solved, strict=True))[:4]))

    @classmethod
    def joined(cls, blocks: Sequence["Runs"]) -> Self:
        """Concatenate the paths of several blocks."""
        return cls(*(np.concatenate(part, axis=-1) for part in zip(*blocks, strict=True)))


@dataclass(frozen=True, eq=False)
class Sample:
    """Measurement of a solver on a problem.

    Attributes
    ----------
    solver : Adaptive
    problem : Problem
        Problem as registered.
    view : Problem
        Problem as the solver sees it.
    budget : Budget
    runs : Runs
    truth : ndarray, shape (d, P)
        Truth on the same paths.
    grid_error, grid_bias : float
        Standard deviation and mean of the truth's error, estimated by the difference from half as many grid steps,
        which is an upper bound for orders of 1/2 or more; 0 if exact.
    """

    solver: Adaptive
    problem: Problem
    view: Problem
    budget: Budget
    runs: Runs
    truth: Array
    grid_error: float = 0.0
    grid_bias: float = 0.0

    @cached_property
    def errors(self) -> Array:
        """Errors at the final time, shape (K, d, P)."""
        return np.asarray(self.runs.ends - self.truth)

    @property
    def tries(self) -> Array:
        """Number of steps including rejected ones, shape (K, P)."""
        return np.asarray(self.runs.steps + self.runs.rejected)

    @property
    def usable(self) -> Array:
        """Indices of the tolerances with enough steps in the mean."""
        return np.flatnonzero(self.runs.steps.mean(axis=-1) >= FEWEST_STEPS)


def measure(solver: Adaptive, problem: Problem, budget: Budget, label: str) -> Sample:
    """Solve a problem at all tolerances and return the sample.

    Parameters
    ----------
    solver : Adaptive
    problem : Problem
        Problem with a pathwise truth.
    budget : Budget
    label : str
        Label of the problem, which determines the noise.

    Raises
    ------
    SchemeError
        If the solver does not solve the form, refuses the problem, or returns an invalid solution.
    """
    if why := why_not(solver, problem):
        raise SchemeError(why)
    view, blocks, truths, coarse = solver.view_of(problem), list[Runs](), list[Array](), list[Array]()
    assert view is not None
    budget = replace(budget, tolerances=budget.tolerances or solver.tolerances)
    for source in budget.sources(label):
        path = brownian_path(source, problem.noise_dim, problem.horizon)
        blocks.append(Runs.of([solved(solver, view, path, tolerance) for tolerance in budget.tolerances]))
        truths.append(truth(problem, path))
        coarse.append(truths[-1] if exact(problem) else truth(problem, path, GRID // 2))
    known = np.concatenate(truths, axis=-1)
    apart = known - np.concatenate(coarse, axis=-1)
    grid = (float(np.max(part)) for part in (apart.std(axis=-1), np.abs(apart.mean(axis=-1))))
    return Sample(solver, problem, view, budget, Runs.joined(blocks), known, *grid)


def why_not(solver: Adaptive, problem: Problem) -> str:
    """Return why a solver cannot be measured on a problem, or an empty string."""
    if problem.pathwise is None:
        return "no solution is known along a given path"
    if problem.records or problem.recall(problem.horizon, 1) is not None:
        return "it is driven by noise other than Brownian motions"
    view = solver.view_of(problem)
    if view is None:
        return f"{solver.name} does not solve a {type(problem).__name__}"
    return solver.refuses(view)


def solved(solver: Adaptive, view: Problem, path: Path, tolerance: float) -> Solved:
    """Run a solver, separately for each group of paths if batches are the unit of the sample.

    Parameters
    ----------
    solver : Adaptive
        Solver, possibly with `in_batches`.
    view : Problem
        Problem in the solver's form.
    path : Path
        Path of one block.
    tolerance : float
        Tolerance of the solver.

    Raises
    ------
    SchemeError
        If the solver does not return a state for each path.
    """
    if not solver.in_batches:
        return checked(solver, solver.solve(view, path, tolerance), path.paths)
    groups = [np.arange(group, path.paths, GROUPS) for group in range(min(GROUPS, path.paths))]
    found = [checked(solver, solver.solve(view, path.only(g), tolerance), len(g)) for g in groups]
    order = np.argsort(np.concatenate(groups), kind="stable")
    state, steps, rejected, evaluations = (
        np.concatenate(part, axis=-1)[..., order] for part in list(zip(*found, strict=True))[:4]
    )
    return Solved(state, steps, rejected, evaluations)


def checked(solver: Adaptive, found: Solved, paths: int) -> Solved:
    """Validate the result of a solver and broadcast its counts to all paths.

    Parameters
    ----------
    solver : Adaptive
        Solver, named in messages.
    found : Solved
        Result of the solver.
    paths : int
        Number P of paths.

    Raises
    ------
    SchemeError
        If the result is not a `Solved`, or its state does not have the shape (d, P).
    """
    if not isinstance(found, Solved):
        raise SchemeError(f"{solver.name} returned {type(found).__name__}, expected Solved")
    state = np.asarray(found.state)
    if state.ndim != 2 or state.shape[-1] != paths:
        raise SchemeError(f"{solver.name} returned a state of shape {state.shape}, expected (d, {paths})")
    steps, rejected, evaluations = (
        np.broadcast_to(each, (paths,)) for each in (found.steps, found.rejected, found.evaluations)
    )
    return Solved(state, steps, rejected, evaluations, found.times, found.W)


def exact(problem: Problem) -> bool:
    """Return whether the pathwise solution is exact."""
    return problem.pathwise is not None and problem.pathwise.exact


def truth(problem: Problem, path: Path, steps: int = GRID) -> Array:
    """Return the solution on a path at the horizon, shape (d, P).

    Noise of a step beyond dW and H is omitted: on n steps this causes an error of size T^(5/2)/(27 n^2) in
    int e^(t - T) dW, because the part of s^2 orthogonal to 1 and s has a coefficient with norm 1/(2 sqrt(180)).

    Parameters
    ----------
    problem : Problem
        Problem with a pathwise truth.
    path : Path
    steps : int
        Number of steps of the truth if it is not exact.
    """
    known = problem.pathwise
    assert known is not None
    steps = min(steps, EXACT) if known.exact else steps
    xi = np.zeros((known.extra_normals, path.paths)) if known.extra_normals else None

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return known.advance(z, t, h, noise._replace(xi=xi))

    return stacked(known.parts(problem.horizon, along(path, steps, known.start(path.paths), advance)))


def stacked(parts: Mapping[str, Array]) -> Array:
    """Concatenate components, shape (d, P)."""
    return np.concatenate([np.atleast_2d(part) for part in parts.values()])


def along(path: Path, steps: int, state: Array, advance: Callable[[Array, float, float, Increment], Array]) -> Array:
    """Return the state after equal steps along a path.

    Parameters
    ----------
    path : Path
    steps : int
        Number of steps, a power of 2.
    state : ndarray
        State at time 0.
    advance : callable, (state, t, h, noise) -> state
    """
    h, stride = path.horizon / steps, TICKS // steps
    here = path.at(0)
    for step in range(steps):
        there = path.at((step + 1) * stride)
        state = advance(state, step * h, h, between(here, there, h))
        here = there
    return state


def fixed(scheme: Scheme, problem: Any, path: Path, steps: int) -> Array:
    """Return the final state of a scheme with equal steps on the same path, shape (d, P).

    Parameters
    ----------
    scheme : Scheme
    problem : object
        Problem in the form that the scheme solves.
    path : Path
    steps : int
        Number of steps, a power of 2.

    Raises
    ------
    UsageError
        If `steps` is not a power of 2, or exceeds the number of ticks.
    """
    if steps < 1 or TICKS % steps:
        raise UsageError(f"the number of steps must be a power of 2 up to {TICKS}, got {steps!r}")
    begin = scheme.enter(problem, problem.initial(path.paths), 0.0, problem.horizon / steps)

    def advance(state: Array, t: float, h: float, noise: Increment) -> Array:
        return np.asarray(scheme.step(problem, state, t, h, noise).state)

    return stacked(scheme.parts(problem, along(path, steps, begin, advance)))
