"""Batches of equal size, so that a compiled function is compiled for one shape only."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from sdaeverify import Array

# Small enough for a batch to fit into the cache.
SIZE = 1024


def in_batches(step: Callable[..., Any], arrays: tuple[Array, ...]) -> Array:
    """Evaluate step(*arrays) for any number of paths by calls with 1024 paths each.

    A batch is padded with copies of its last path. The numbers of a path depend neither on the other paths nor,
    because all batches have the same even size, on its position.

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
    """Vectorise a JAX step of one path over the last axis, compiled in double precision for each shape.

    Parameters
    ----------
    one : callable
        Function of (x, t, h, *noise) without the axis of paths.

    Returns
    -------
    callable
        The same function with a last axis of paths.
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
