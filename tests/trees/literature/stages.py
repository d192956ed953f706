"""What the steps of all families share: sums over stages, columns of the noise, Stratonovich's drift."""

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from sdaeverify import SDE, Array, Increment


def table(*rows: Sequence[float]) -> Array:
    """Return a table of coefficients, shape (s, s), from its rows below the diagonal or longer ones."""
    full = np.zeros((len(rows), len(rows)))
    for full_row, row in zip(full, rows, strict=True):
        full_row[: len(row)] = row
    return full


def weighted(weights: Array, stages: Sequence[Array]) -> Any:
    """Return the sum of the stages that are known, each times its weight; 0 without any."""
    return sum((w * stage for w, stage in zip(weights, stages, strict=False) if w), 0.0)


def noise_matrix(problem: SDE, t: float, x: Array) -> Array:
    """Return B(t, x) on every path, shape (d, l, P)."""
    return np.broadcast_to(problem.diffusion(t, x), (*x.shape[:1], problem.noise_dim, *x.shape[1:]))


def own_columns(problem: SDE, t: float, states: Sequence[Array]) -> Array:
    """Return the columns B_k(t, x_k), each at a state of its own, shape (d, l, P)."""
    return np.stack([noise_matrix(problem, t, x)[:, k] for k, x in enumerate(states)], axis=1)


def stratonovich_drift(problem: SDE, t: float, x: Array) -> Array:
    """Return f - (1/2) sum_k DB_k B_k, shape (d, P)."""
    B = noise_matrix(problem, t, x)
    turned = (problem.derivative_of_diffusion(t, x, B[:, k])[:, k] for k in range(problem.noise_dim))
    return problem.drift(t, x) - 0.5 * sum(turned)


def signs(noise: Increment) -> Array:
    """Return two-point variables of the size sqrt(h), which a bounded law makes of H, shape (l, P)."""
    return np.sqrt(12.0) * noise.H


def antisymmetric(pairs: Array, l: int) -> Array:
    """Return the matrix V with V_kj = pairs of k > j and V_jk = -V_kj, shape (l, l, P).

    Parameters
    ----------
    pairs : ndarray, shape (l (l - 1)/2, P)
        Of (0, 1), (0, 2), ..., (1, 2), ...
    l : int
    """
    V = np.zeros((l, l, pairs.shape[-1]))
    for (j, k), value in zip(combinations(range(l), 2), pairs, strict=True):
        V[k, j], V[j, k] = value, -value
    return V
