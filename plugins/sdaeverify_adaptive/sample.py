"""What is measured: a solver's final states at several tolerances, and the truth, on the same paths."""

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

# Paths that are solved at once: as many in each group.
BLOCK = 400
# Steps of a truth that is exact.
EXACT = 2**10
# A tolerance with fewer steps in the mean says nothing of a rate.
FEWEST_STEPS = 16


@dataclass(frozen=True)
class Budget:
    """How much is sampled.

    Attributes
    ----------
    paths : int
    tolerances : tuple of float
        Largest first; the range that a solver names if left out.
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
            raise UsageError(
                f"tolerances must be positive and fall, three of them at least, or no rate can be told; got {given}"
            )
        # Said before anything is solved.
        Settings(seed=self.seed)

    def sources(self, label: str) -> Iterator[Source]:
        """Yield the addresses of all blocks of paths; a run with fewer than a block draws others."""
        size = min(BLOCK, self.paths)
        for block, done in enumerate(range(0, self.paths, BLOCK)):
            yield Source(self.seed, label, block, size, min(size, self.paths - done))


class Runs(NamedTuple):
    """Final states at several tolerances or numbers of steps, and what they took.

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
        """Return what came of several runs on the same paths."""
        return cls(*(np.stack(part) for part in list(zip(*solved, strict=True))[:4]))

    @classmethod
    def joined(cls, blocks: Sequence["Runs"]) -> Self:
        """Return the same on the paths of several blocks."""
        return cls(*(np.concatenate(part, axis=-1) for part in zip(*blocks, strict=True)))


@dataclass(frozen=True, eq=False)
class Sample:
    """What was measured of a solver on a problem.

    Attributes
    ----------
    solver : Adaptive
    problem : Problem
        As registered.
    view : Problem
        As the solver sees it.
    budget : Budget
    runs : Runs
    truth : ndarray, shape (d, P)
        On the same paths.
    grid_error, grid_bias : float
        Standard deviation and mean of the truth's own error, as the step from half as many grid steps tells them: of
        an order of 1/2 or more it is at most as large; 0 if exact.
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
        """Errors at the end, shape (K, d, P)."""
        return np.asarray(self.runs.ends - self.truth)

    @property
    def tries(self) -> Array:
        """Steps, rejected ones counted, shape (K, P)."""
        return np.asarray(self.runs.steps + self.runs.rejected)

    @property
    def usable(self) -> Array:
        """Indices of the tolerances with enough steps in the mean."""
        return np.flatnonzero(self.runs.steps.mean(axis=-1) >= FEWEST_STEPS)


def measure(solver: Adaptive, problem: Problem, budget: Budget, label: str) -> Sample:
    """Return what a solver comes to on a problem at all tolerances.

    Parameters
    ----------
    solver : Adaptive
    problem : Problem
        With a truth on a given path.
    budget : Budget
    label : str
        Of the problem: it determines the noise.

    Raises
    ------
    SchemeError
        If the solver does not see the problem, refuses it, or returns something that is no solution.
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
        return "it is driven by more than Brownian motions"
    view = solver.view_of(problem)
    if view is None:
        return f"{solver.name} does not solve a {type(problem).__name__}"
    return solver.refuses(view)


def solved(solver: Adaptive, view: Problem, path: Path, tolerance: float) -> Solved:
    """Return what a solver returns, batch by batch where its batches are the unit that is sampled.

    Parameters
    ----------
    solver : Adaptive
        In batches or not.
    view : Problem
        In the solver's form.
    path : Path
        Of one block.
    tolerance : float
        That it is given.

    Raises
    ------
    SchemeError
        If it returns something else than a state for each path.
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
    """Return what a solver returned, its counts as an array over the paths.

    Parameters
    ----------
    solver : Adaptive
        Whose name is told.
    found : Solved
        What it returned.
    paths : int
        Number P of paths that it was given.

    Raises
    ------
    SchemeError
        If it is no `Solved`, or its state has another shape than components by paths.
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
    """Tell whether the solution on a path is known without an error of its own."""
    return problem.pathwise is not None and problem.pathwise.exact


def truth(problem: Problem, path: Path, steps: int = GRID) -> Array:
    """Return the solution on a path at the horizon, shape (d, P).

    What it needs of a step beyond dW and H is left out: on n steps this makes an error of the size T^(5/2)/(27 n^2)
    of int e^(t - T) dW, the coefficient of s^2 having the norm 1/(2 sqrt(180)) beside 1 and s.

    Parameters
    ----------
    problem : Problem
        With a truth on a given path.
    path : Path
    steps : int
        Of the truth where it has an error of its own.
    """
    known = problem.pathwise
    assert known is not None
    steps = min(steps, EXACT) if known.exact else steps
    xi = np.zeros((known.extra_normals, path.paths)) if known.extra_normals else None

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return known.advance(z, t, h, noise._replace(xi=xi))

    return stacked(known.parts(problem.horizon, along(path, steps, known.start(path.paths), advance)))


def stacked(parts: Mapping[str, Array]) -> Array:
    """Return components below each other, shape (d, P)."""
    return np.concatenate([np.atleast_2d(part) for part in parts.values()])


def along(path: Path, steps: int, state: Array, advance: Callable[[Array, float, float, Increment], Array]) -> Array:
    """Return the state after steps of one length.

    Parameters
    ----------
    path : Path
    steps : int
        A power of 2.
    state : ndarray
        At time 0.
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
    """Return the final state of a scheme with steps of one length, on the same path; shape (d, P).

    Parameters
    ----------
    scheme : Scheme
    problem : object
        A problem in the form that the scheme solves.
    path : Path
    steps : int
        A power of 2.

    Raises
    ------
    UsageError
        If it is none, or there are more steps than ticks.
    """
    if steps < 1 or TICKS % steps:
        raise UsageError(f"the number of steps must be a power of 2 up to {TICKS}, got {steps!r}")
    begin = scheme.enter(problem, problem.initial(path.paths), 0.0, problem.horizon / steps)

    def advance(state: Array, t: float, h: float, noise: Increment) -> Array:
        return np.asarray(scheme.step(problem, state, t, h, noise).state)

    return stacked(scheme.parts(problem, along(path, steps, begin, advance)))
