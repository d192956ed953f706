"""Exact means and second moments along a run of a linear step with a lag, from a deterministic start.

The known of a step are y_n and the lagged values v_n, ..., v_{n+m-1}; a step adds v_{n+m} = delta x_{n+1} +
(1 - delta) x_n and forgets v_n, whose place the new one takes. All others keep their moments, so that a step costs
a multiple of m.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Mesh
from .delay_step import LinearDelayStep, arguments


class Start(NamedTuple):
    """Where a run begins.

    Attributes
    ----------
    y : ndarray, shape (k,)
        y_0.
    lagged : ndarray, shape (m, d)
        v_0, ..., v_{m-1}, which come from the history left of the start; v_0, ..., v_N are enough for N steps.
    """

    y: Array
    lagged: Array


class RunMoments(NamedTuple):
    """Moments at every mesh point.

    Attributes
    ----------
    mean : ndarray, shape (N + 1, k)
        E y_n.
    second : ndarray, shape (N + 1, k, k)
        E y_n y_n^T.
    """

    mean: Array
    second: Array


def run_moments(step: LinearDelayStep, mesh: Mesh, start: Start, steps: int) -> RunMoments:
    """Return the moments of a run of some steps.

    Parameters
    ----------
    step : LinearDelayStep
    mesh : Mesh
        How the delay lies on the steps.
    start : Start
        State of the scheme, and the lagged values that the run uses.
    steps : int
        Length of the run.

    Returns
    -------
    RunMoments
    """
    # A run that is shorter than the delay reaches no later values of its past.
    k, d, m = step.rows, step.delayed, min(mesh.m, max(steps, 1) + 1)
    known = np.concatenate([start.y, np.ravel(start.lagged[:m]), [1.0]])
    # Of (y_n, all lagged values, 1): the last column carries the means.
    P = np.outer(known, known)
    chosen = arguments(k, d, Mesh(min(m, 2), mesh.delta))
    found = [P[:k, [*range(k), -1]]]
    for n in range(steps):
        lagged = [_places(k, d, (n + i) % m) for i in range(min(m, 2))]
        used = np.concatenate([np.arange(k), *lagged])
        taken = chosen @ P[used]
        _advance(P, step, Known(taken, taken[:, used] @ chosen.T), lagged[:1], mesh.delta)
        found.append(P[:k, [*range(k), -1]])
    collected = np.array(found)
    return RunMoments(collected[..., -1], collected[..., :-1])


class Known(NamedTuple):
    """Moments of z = (y_n, v_n, known part of v_{n+1}).

    Attributes
    ----------
    taken : ndarray, shape (k + 2 d, k + m d + 1)
        With (y_n, all lagged values, 1).
    within : ndarray, shape (k + 2 d, k + 2 d)
        E z z^T.
    """

    taken: Array
    within: Array


def _places(k: int, d: int, place: int) -> Array:
    return k + d * place + np.arange(d)


def _advance(P: Array, step: LinearDelayStep, known: Known, forgotten: list[Array], delta: float) -> None:
    # `forgotten` are the places of v_n, where v_{n+m} is put; without a delay there are none.
    k, d, maps = step.rows, step.delayed, step.maps
    second = (maps @ known.within @ maps.swapaxes(1, 2)).sum(axis=0)
    cross = step.drift @ known.taken
    # The new lagged value with all that was known, with y_{n+1} and with itself.
    fresh = delta * cross[:d] + (1.0 - delta) * P[:d]
    with_y = delta * second[:d] + (1.0 - delta) * cross[:, :d].T
    for slot in forgotten:
        P[slot], P[:, slot], cross[:, slot] = fresh, fresh.T, with_y.T
        P[np.ix_(slot, slot)] = delta * with_y[:, :d] + (1.0 - delta) * fresh[:, :d]
    cross[:, :k] = second
    P[:k], P[:, :k] = cross, cross.T
