"""One step of a scheme with a lag on a linear equation, as matrices.

    y_{n+1} = R y_n + S v_n + V v_{n+1} + sum_j (R_j y_n + S_j v_n + V_j v_{n+1}) xi_j

y is the scheme's own state of k rows, the first d of which are x; the rest is algebraic. With tau = (m - delta) h,
as in Qu, Huang & Liu (2010), (2.11),

    v_n = delta x_{n-m+1} + (1 - delta) x_{n-m} .

For m = 1 only (1 - delta) x_n of v_{n+1} is known before the step, which is what its columns multiply there; for
m = 0 nothing of it is, and v_n = x_n.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Mesh


class LinearDelayStep(NamedTuple):
    """The matrices of one step: columns for y_n, then for v_n, then for the known part of v_{n+1}.

    Attributes
    ----------
    drift : ndarray, shape (k, k + 2 d)
    noise : ndarray, shape (l, k, k + 2 d)
        Of independent standard normals xi_j: a factor sqrt(h) is included.
    """

    drift: Array
    noise: Array

    @property
    def rows(self) -> int:
        """Number k of components of y."""
        return len(self.drift)

    @property
    def delayed(self) -> int:
        """Number d of components of x, which are the first of y."""
        return int(self.drift.shape[1] - self.rows) // 2

    @property
    def maps(self) -> Array:
        """The drift and then the noises, shape (1 + l, k, k + 2 d)."""
        return np.concatenate([self.drift[None], self.noise])


class Lagged(NamedTuple):
    """A step as a recursion y_{n+1} = sum_i A_i y_{n-i}, with noises of the same kind; I different lags.

    Attributes
    ----------
    lags : ndarray, shape (I,)
        Ascending, from 0.
    maps : ndarray, shape (1 + l, I, k, k)
        The drift A_i and then the noises; columns of what is not delayed are 0, except at lag 0.
    """

    lags: Array
    maps: Array


def lagged(step: LinearDelayStep, mesh: Mesh) -> Lagged:
    """Return a step as a recursion in y alone; at most four lags have coefficients."""
    k, d = step.rows, step.delayed
    now, following = _weights(mesh)
    lags = np.unique([0, *(lag for lag, _ in now + following)])
    maps, sources = np.zeros((len(step.noise) + 1, len(lags), k, k)), step.maps
    maps[:, 0] = sources[..., :k]
    for first, pairs in ((k, now), (k + d, following)):
        for lag, weight in pairs:
            maps[:, np.searchsorted(lags, lag), :, :d] += weight * sources[..., first : first + d]
    used = (lags == 0) | maps.any(axis=(0, 2, 3))
    return Lagged(lags[used], maps[:, used])


def _weights(mesh: Mesh) -> tuple[tuple[tuple[int, float], ...], tuple[tuple[int, float], ...]]:
    # Pairs (lag, weight): what x_{n-lag} weighs in v_n, and in the known part of v_{n+1}.
    m, delta = mesh
    if m == 0:
        return ((0, 1.0),), ()
    now = ((m - 1, delta), (m, 1.0 - delta))
    return now, tuple((lag - 1, weight) for lag, weight in now if lag > 0)


def arguments(k: int, d: int, mesh: Mesh) -> Array:
    """Return the map of (y_n, v_n, ..., v_{n+m-1}) to (y_n, v_n, known part of v_{n+1}).

    Parameters
    ----------
    k : int
        Numbers in the memory y of the scheme.
    d : int
        Numbers in a solution x.
    mesh : Mesh
        How the delay lies on the steps.
    """
    m, delta = mesh
    chosen = np.zeros((k + 2 * d, k + m * d))
    chosen[:k, :k] = np.eye(k)
    chosen[k : k + d, k : k + d] += np.eye(d) if m > 0 else 0.0
    if m == 0:
        chosen[k : k + d, :d] = np.eye(d)
    elif m == 1:
        chosen[k + d :, :d] = (1.0 - delta) * np.eye(d)
    else:
        chosen[k + d :, k + d : k + 2 * d] = np.eye(d)
    return chosen
