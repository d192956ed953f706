"""Points of a manifold g = 0 near given points."""

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from .linalg import apply_transposed, product_transposed, solve

STEPS = 50


def onto_manifold(
    g: Callable[[Array], Array], dg: Callable[[Array], Array], normals: Callable[[Array], Array], x: Array
) -> Array:
    """Solve g(y) = 0 by Gauss-Newton steps y <- y - N(y)^T [Dg(y) N(y)^T]^{-1} g(y) from y = x.

    Parameters
    ----------
    g : callable, ndarray of shape (n, P) -> ndarray of shape (m, P)
    dg, normals : callable, ndarray of shape (n, P) -> ndarray of shape (m, n, P)
        Dg, and the rows N along which points move.
    x : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (n, P)
        Not finite on paths where the iteration breaks down.
    """
    y = x
    for _ in range(STEPS):
        value = g(y)
        if np.abs(value).max() <= 4.0 * np.finfo(float).eps:
            break
        N = normals(y)
        y = y - apply_transposed(N, solve(product_transposed(dg(y), N), value))
    return y
