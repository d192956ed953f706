"""Distances from the limit eps = 0 at a fixed step size, with the same noise for all eps.

Laurent (2022), Theorem 2.9: |X_n^eps - X_n^0| <= C_h sqrt(eps) and |zeta(X_n^eps)| <= C_h sqrt(eps), and O(eps) if
sigma = 0. The rates are visible for eps far below h: in a few steps of a few paths at eps = h 2^-16, ..., h 2^-28,
where X^0 is the same scheme at eps = 0. For smaller eps, rounding dominates. Without noise the paths begin where the
noisy ones of X^0 end, because at the problem's start the drift may be tangential.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Mask, Scheme
from sdaeverify.measuring import Estimate, group_sums, jackknife
from sdaeverify.numerics import norm, slope_weights

from .._members import FEW_PATHS, FEW_STEPS, few_steps, member, short_step

POWERS = tuple(range(16, 29, 2))
QUANTITIES = ("x", "zeta", "x without noise", "zeta without noise")
# A distance is used if it exceeds this multiple of the rounding of all steps.
ABOVE_FLOOR = 100.0
NEEDED = 4


class LimitDistances(NamedTuple):
    """Squared distances, maximal over the steps of each path, for E stiffness parameters.

    Attributes
    ----------
    h : float
    eps : ndarray, shape (E,)
        Descending.
    squares : ndarray, shape (G, 4, E)
        Of |X^eps - X^0| and of |zeta(X^eps)|, with noise and without; sums over groups of paths.
    counts : ndarray, shape (G,)
        Paths in each group.
    floor : ndarray, shape (4,)
        Bound of the rounding error of a distance.
    failed : float
        Share of the paths on which some step had no root or was not finite; they are excluded.
    """

    h: Array
    eps: Array
    squares: Array
    counts: Array
    floor: Array
    failed: Array


class Slope(NamedTuple):
    """The exponent of eps in a distance.

    Attributes
    ----------
    estimate : Estimate
        NaN if too few distances are above rounding, infinite if none is.
    distances : ndarray, shape (E,)
        Root mean squares.
    """

    estimate: Estimate
    distances: Array


def limit_distances(scheme: Scheme, view: Any, seed: int) -> LimitDistances:
    """Return the distances on paths from the problem's start, whose noise is determined by the seed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        A member of a family with a stiffness eps, whose limit eps = 0 is a member, too.
    seed : int
        Of the noise.
    """
    h = short_step(view)
    eps = h * 0.5 ** np.array(POWERS)
    noise = few_steps(scheme, view, h, seed)
    at_rest = [Increment(each, each) for each in np.zeros((FEW_STEPS, view.noise_dim, FEW_PATHS))]
    problems: list[Any] = [member(view, each) for each in (0.0, *eps)]
    # Without noise, the equation also loses its terms with sigma^2.
    quiet = [replace(problem, strength=0.0, truths=()) for problem in problems]
    with np.errstate(all="ignore"):
        moving = _distances(scheme, problems, _Path(h, problems[0].initial(FEW_PATHS), noise))
        still = _distances(scheme, quiet, _Path(h, moving.end, at_rest))
    sound = moving.sound & still.sound
    both = np.concatenate([moving.distances, still.distances])[..., sound]
    return LimitDistances(
        np.asarray(h),
        eps,
        group_sums(both**2),
        group_sums(np.ones(both.shape[-1])),
        ABOVE_FLOOR * FEW_STEPS * np.finfo(float).eps * np.concatenate([moving.scale, still.scale]),
        np.asarray(1.0 - sound.mean()),
    )


def limit_slopes(record: LimitDistances) -> dict[str, Slope]:
    """Return the exponent of each of `QUANTITIES`."""
    return {name: _slope(record, index) for index, name in enumerate(QUANTITIES)}


def _slope(record: LimitDistances, index: int) -> Slope:
    unknown = Slope(Estimate(nan, nan), np.full(len(record.eps), nan))
    if not record.counts.all():
        return unknown
    sums, floor = record.squares[:, index], float(record.floor[index])
    distances = np.sqrt(sums.sum(axis=0) / record.counts.sum())
    used = distances > floor
    if not used.any():
        return Slope(Estimate(inf, 0.0), distances)
    if used.sum() < NEEDED:
        return unknown._replace(distances=distances)
    weights = slope_weights(np.log2(record.eps[used]))
    found = jackknife(sums[:, used], record.counts, lambda means: float(weights @ (0.5 * np.log2(means))))
    return Slope(found, distances)


class _Path(NamedTuple):
    # Initial states (d, P), and the noise of their steps of size h.
    h: float
    x: Array
    noise: Sequence[Increment]


class _Distances(NamedTuple):
    # The largest distances over all steps (2, E, P), the paths on which every step succeeded (P,), the size of the
    # terms that cancel in either distance (2,), and the final states of the limit (d, P).
    distances: Array
    sound: Mask
    scale: Array
    end: Array


def _distances(scheme: Scheme, problems: Sequence[Any], given: _Path) -> _Distances:
    # The first problem is the limit.
    (limit, sound), *others = (_path(scheme, problem, given) for problem in problems)
    found = []
    for problem, (path, usable) in zip(problems[1:], others, strict=True):
        gaps = [norm(x - y) for x, y in zip(path, limit, strict=True)]
        found.append([np.max(gaps, axis=0), np.max([norm(problem.constraint(x)) for x in path], axis=0)])
        sound = sound & usable
    sizes = [(norm(x)[sound], (problems[0].linearised(x).size() * norm(x))[sound]) for x in limit]
    return _Distances(np.array(found).swapaxes(0, 1), sound, np.max(sizes, axis=(0, 2), initial=0.0), limit[-1])


def _path(scheme: Scheme, problem: Any, given: _Path) -> tuple[list[Array], Mask]:
    state, step = scheme.enter(problem, problem.state(given.x), 0.0, given.h), scheme.prepare(problem, given.h)
    path, sound = [], np.ones(given.x.shape[1], dtype=bool)
    for n, increment in enumerate(given.noise):
        result = step(state, n * given.h, increment)
        state, failed = result.state, result.failed
        path.append(scheme.parts(problem, state)["x"])
        sound = sound & np.isfinite(path[-1]).all(axis=0) & (True if failed is None else ~failed)
    return path, sound
