"""The strong study in diffrax: its Euler scheme on its virtual Brownian tree, one compiled function."""

from collections.abc import Callable

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.study import GRID, STEPS, X_0, A, B, Means, means


def compiled(paths: int) -> Callable[[], Means]:
    """Return the study in double precision, already compiled.

    The tree is resolved to the finest step, so that it holds every increment without interpolation and no more.
    """
    jax.config.update("jax_enable_x64", True)
    keys = jax.random.split(jax.random.key(1), paths)
    errors = jax.jit(jax.vmap(_errors)).lower(keys).compile()
    return lambda: means(np.asarray(errors(keys)).T)


def _errors(key: jax.Array) -> jax.Array:
    tree = diffrax.VirtualBrownianTree(0.0, 1.0, tol=1.0 / STEPS[-1], shape=(), key=key)
    grid = jnp.asarray(GRID)
    W = jax.vmap(lambda t: tree.evaluate(0.0, t))(grid)
    exact = X_0 * jnp.exp((A - 0.5 * B * B) * grid + B * W)
    noise = diffrax.ControlTerm(lambda t, x, args: B * x, tree)
    terms = diffrax.MultiTerm(diffrax.ODETerm(lambda t, x, args: A * x), noise)
    return jnp.stack([abs(_solution(terms, n, grid) - exact).max() for n in STEPS])


def _solution(terms: diffrax.MultiTerm, n: int, grid: jax.Array) -> jax.Array:
    # One step more than needed: the sum of the steps may fall short of 1 by rounding.
    solution = diffrax.diffeqsolve(
        terms,
        diffrax.Euler(),
        0.0,
        1.0,
        1.0 / n,
        X_0,
        saveat=diffrax.SaveAt(ts=grid),
        max_steps=n + 1,
        throw=False,
    )
    return solution.ys
