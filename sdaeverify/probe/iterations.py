"""Iterations a step takes, for every stiffness parameter at a fixed step size.

Laurent (2022), Theorem 2.12: the implicit step is a fixed point problem whose contraction factor is O(sqrt h)
uniformly in eps, so that one number of iterations is enough for all eps.
"""

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..noise import Increment
from ..scheme import Scheme, Step
from .stiffness import FEW_PATHS, few_steps, member, short_step, stiffnesses

PER_DECADE = 2
COUNTED = "iterations"


class Iterations(NamedTuple):
    """What the steps took, for E stiffness parameters and C counters.

    Attributes
    ----------
    h : float
    eps : ndarray, shape (E,)
        Ascending.
    mean, error, most : ndarray, shape (C, E)
        Mean over steps and paths, its standard error from the means of the paths, and the largest.
    failed : ndarray, shape (E,)
        Share of the steps without root; what they took does not count.
    """

    h: Array
    eps: Array
    mean: Array
    error: Array
    most: Array
    failed: Array


def counters(scheme: Scheme, view: Any) -> list[str]:
    """Return the names of a step's costs that are iterations, in order."""
    h, zeros = short_step(view), np.zeros((view.noise_dim, 2))
    result: Step = scheme.prepare(view, h)(scheme.start(view, 2, h), 0.0, Increment(zeros, zeros))
    return sorted(name for name in result.costs if COUNTED in name)


def iterations(scheme: Scheme, view: Any, seed: int) -> Iterations:
    """Return what a few steps take from the problem's start, the noise being the same for every eps."""
    h, eps = short_step(view), stiffnesses(PER_DECADE)
    noise = few_steps(scheme, view, h, seed)
    with np.errstate(all="ignore"):
        found = [_counted(scheme, member(view, each), h, noise) for each in eps]
    mean, error, most, failed = zip(*found, strict=True)
    return Iterations(np.asarray(h), eps, np.array(mean).T, np.array(error).T, np.array(most).T, np.array(failed))


def _counted(scheme: Scheme, problem: Any, h: float, noise: list[Increment]) -> tuple[Array, Array, Array, float]:
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
