"""Evaluation of a function at several points in one call, as if the points were further paths."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from sdaeverify import Array

# Largest number of values evaluated together; beyond it, memory traffic outweighs the saved calls.
TOGETHER = 2**13


def side_by_side(f: Callable[[float, Array], Array], t: float, points: Sequence[Array]) -> Iterator[Array]:
    """Yield f(t, x) of every point x.

    Parameters
    ----------
    f : callable, (t, ndarray of shape (d, Q)) -> ndarray of shape (..., Q) or (..., 1)
    t : float
    points : sequence of ndarrays, shape (d, P)
    """
    P = points[0].shape[1]
    if len(points) * points[0].size > TOGETHER:
        yield from (f(t, x) for x in points)
        return
    value = f(t, np.concatenate(points, axis=1))
    yield from (value if value.shape[-1] == 1 else value[..., i * P : (i + 1) * P] for i in range(len(points)))
