"""A step of one path in JAX as a compiled step of all paths at once."""

from collections.abc import Callable
from typing import Any

import jax

from sdaeverify.bridges import Compiled


def batched(one: Callable[..., jax.Array]) -> Compiled:
    """Return a step of one path for all paths at once, compiled in double precision for each shape it meets."""

    def all_paths(y: jax.Array, t: jax.Array, h: jax.Array, *numbers: jax.Array) -> jax.Array:
        axes = (-1, None, None, *[-1] * len(numbers))
        return jax.vmap(one, in_axes=axes, out_axes=-1)(y, t, h, *numbers)

    compiled = jax.jit(all_paths)

    def step(*given: Any) -> jax.Array:
        with jax.enable_x64(True):
            return compiled(*given)

    return step
