"""Iterations of a step for every stiffness parameter: in a few steps of one size, and in whole runs at several sizes.

Laurent (2022), Theorem 2.12: the implicit step is a fixed-point problem whose contraction factor is O(sqrt h)
uniformly in eps, so one number of iterations is enough for all eps.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Mask, Scheme, Step

from .._members import FEW_PATHS, few_steps, member, short_step, stiffnesses

PER_DECADE = 2
COUNTED = "iterations"
# Stiffness parameters of whole runs, number of their step sizes, and largest count that is distinguished.
RUNS = (1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
LEVELS, MOST = 5, 128
# A run ends early if a larger share of its steps has no root.
HOPELESS = 0.1


class Iterations(NamedTuple):
    """Iterations of a few steps, for E stiffness parameters and C counters.

    Attributes
    ----------
    h : float
    eps : ndarray, shape (E,)
        Ascending.
    mean, error, most : ndarray, shape (C, E)
        Mean over steps and paths, its standard error from the means of the paths, and the maximum.
    failed : ndarray, shape (E,)
        Share of the steps without a root, whose iterations are excluded.
    """

    h: Array
    eps: Array
    mean: Array
    error: Array
    most: Array
    failed: Array


class RunIterations(NamedTuple):
    """Iterations of whole runs, for E stiffness parameters, H step sizes and C counters.

    Attributes
    ----------
    h : ndarray, shape (H,)
        From coarse to fine.
    eps : ndarray, shape (E,)
        Ascending.
    above : ndarray, shape (C, E, H, 128)
        Share of the steps with a root that took more than 0, 1, ..., 127 iterations, averaged over paths.
    most : ndarray, shape (C, E, H)
        The largest count.
    paths : ndarray, shape (E, H)
        Number of paths that had a step with a root.
    failed : ndarray, shape (E, H)
        Share of the steps without a root.
    """

    h: Array
    eps: Array
    above: Array
    most: Array
    paths: Array
    failed: Array


def counters(scheme: Scheme, view: Any) -> list[str]:
    """Return the names of a step's costs that are iterations, in order."""
    h, zeros = short_step(view), np.zeros((view.noise_dim, 2))
    result: Step = scheme.prepare(view, h)(scheme.start(view, 2, h), 0.0, Increment(zeros, zeros))
    return sorted(name for name in result.costs if COUNTED in name)


def iterations(scheme: Scheme, view: Any, seed: int) -> Iterations:
    """Return the iterations of a few steps from the problem's start, with the same noise for every eps.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        A member of a family with a stiffness eps.
    seed : int
        Of the noise.
    """
    h, eps = short_step(view), stiffnesses(PER_DECADE)
    noise = few_steps(scheme, view, h, seed)
    with np.errstate(all="ignore"):
        found = [_count_costs(scheme, member(view, each), h, noise) for each in eps]
    mean, error, most, failed = zip(*found, strict=True)
    return Iterations(np.asarray(h), eps, np.array(mean).T, np.array(error).T, np.array(most).T, np.array(failed))


def _count_costs(scheme: Scheme, problem: Any, h: float, noise: list[Increment]) -> tuple[Array, Array, Array, float]:
    names, step = counters(scheme, problem), scheme.prepare(problem, h)
    state, counts = scheme.start(problem, FEW_PATHS, h), []
    for n, increment in enumerate(noise):
        result = step(state, n * h, increment)
        taken = np.array([np.broadcast_to(result.costs[name], FEW_PATHS) for name in names], dtype=float)
        counts.append(taken if result.failed is None else np.where(result.failed, np.nan, taken))
        state = result.state
    table = np.array(counts)
    lost = np.isnan(table[:, 0])
    if lost.all(axis=0).any():
        table = table[..., ~lost.all(axis=0)]
    of_paths = np.nanmean(table, axis=0) if table.size else np.full((len(names), 1), np.nan)
    error = of_paths.std(axis=1) / np.sqrt(of_paths.shape[1])
    most = np.nanmax(table, axis=(0, 2)) if table.size else np.full(len(names), np.nan)
    return of_paths.mean(axis=1), error, most, float(lost.mean())


def run_iterations(scheme: Scheme, view: Any, steps: Sequence[int], seed: int) -> RunIterations:
    """Return the iterations of runs to the horizon, for the first five of the given numbers of steps.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        A member of a family with a stiffness eps.
    steps : sequence of int
        Numbers of steps to the horizon.
    seed : int
        Of the noise.
    """
    eps, sizes = np.array(RUNS), view.horizon / np.array(steps[:LEVELS])
    with np.errstate(all="ignore"):
        found = [[_count_along_run(scheme, member(view, each), float(h), seed) for h in sizes] for each in eps]
    above, most, paths, failed = (
        np.array([[np.asarray(run[index]) for run in runs] for runs in found]) for index in range(4)
    )
    return RunIterations(sizes, eps, np.moveaxis(above, 2, 0), np.moveaxis(most, 2, 0), paths, failed)


def _count_along_run(scheme: Scheme, problem: Any, h: float, seed: int) -> tuple[Array, Array, int, float]:
    """Return the rows of `above` and `most`, and `paths` and `failed`, of one run."""
    names, step = counters(scheme, problem), scheme.prepare(problem, h)
    rng, state = np.random.Generator(np.random.Philox(seed)), scheme.start(problem, FEW_PATHS, h)
    steps, lost, counts, rooted = round(problem.horizon / h), 0, [], []
    for n in range(steps):
        xi = rng.standard_normal((2, problem.noise_dim, FEW_PATHS))
        noise = scheme.law.increment(Increment(np.sqrt(h) * xi[0], np.sqrt(h / 12.0) * xi[1]), h)
        result = step(state, n * h, noise)
        counts.append([np.broadcast_to(result.costs[name], FEW_PATHS) for name in names])
        rooted.append(np.ones(FEW_PATHS, dtype=bool) if result.failed is None else ~result.failed)
        lost += int(np.count_nonzero(~rooted[-1]))
        if lost > HOPELESS * FEW_PATHS * steps:
            break
        state = result.state
    return _share_counts(np.array(counts, dtype=float), np.array(rooted))


def _share_counts(taken: Array, rooted: Mask) -> tuple[Array, Array, int, float]:
    """Return the result of `_count_along_run` from counts, shape (N, C, P), and steps with a root, shape (N, P)."""
    good = np.where(rooted[:, None], taken, 0.0)
    had = rooted.any(axis=0)
    shares, above = 1.0 / rooted.sum(axis=0)[had], np.zeros((taken.shape[1], MOST))
    # Shares for counts above the maximum, which are most of them, stay zero.
    for count in range(np.count_nonzero(np.arange(MOST) < np.fmax.reduce(good, axis=None, initial=0.0))):
        above[:, count] = ((good > count).sum(axis=0)[:, had] * shares).sum(axis=1)
    return above / max(1, had.sum()), good.max(axis=(0, 2)), int(had.sum()), float(1.0 - rooted.mean())
