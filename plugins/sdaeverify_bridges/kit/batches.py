"""Paths in batches of one size: what is compiled for a shape is compiled once."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from sdaeverify import Array

# So few that a batch stays in the cache.
SIZE = 1024


def in_batches(step: Callable[..., Any], arrays: tuple[Array, ...]) -> Array:
    """Return step(*arrays) for any number of paths, put together from calls with 1024 of them.

    A batch is filled up with copies of its last path: the numbers of a path depend neither on the others nor, because
    all batches are long and of even size, on its place among them.

    Parameters
    ----------
    step : callable, arrays of shape (k, size) -> array of shape (d, size)
    arrays : tuple of ndarray, each of shape (k, P)

    Returns
    -------
    ndarray, shape (d, P)
    """
    P = arrays[0].shape[-1]
    results = [np.asarray(step(*batch))[..., :used] for used, batch in _batches(arrays, P)]
    return results[0] if len(results) == 1 else np.concatenate(results, axis=-1)


def vectorised(one: Callable[..., Any]) -> Callable[..., Any]:
    """Return a step of one path in JAX for all paths at once, compiled in double precision for each shape it meets.

    Parameters
    ----------
    one : callable
        Of (x, t, h, *noise) without the axis of paths.

    Returns
    -------
    callable
        The same with that axis, the last one.
    """
    import jax  # noqa: PLC0415 - it may be missing

    def all_paths(x: Any, t: Any, h: Any, *noise: Any) -> Any:
        return jax.vmap(one, in_axes=(-1, None, None, *[-1] * len(noise)), out_axes=-1)(x, t, h, *noise)

    compiled = jax.jit(all_paths)

    def step(*given: Any) -> Any:
        with jax.enable_x64(True):
            return compiled(*given)

    return step


def _batches(arrays: tuple[Array, ...], P: int) -> Iterator[tuple[int, tuple[Array, ...]]]:
    for begin in range(0, P, SIZE):
        used = min(SIZE, P - begin)
        yield used, tuple(_fill(array[..., begin : begin + used], SIZE - used) for array in arrays)


def _fill(array: Array, missing: int) -> Array:
    return np.pad(array, [(0, 0)] * (array.ndim - 1) + [(0, missing)], mode="edge") if missing else array
