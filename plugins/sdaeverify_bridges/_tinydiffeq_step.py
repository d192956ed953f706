"""One step of a solver of tinydiffeq as a compiled function of arrays with paths last."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import tinydiffeq

from sdaeverify import SDE, DelaySDAE
from sdaeverify_bridges.kit import Coefficients, Compiled, Foreign, vectorised


def sde_step(solver: str, problem: SDE) -> Compiled:
    """Return the step of ``solve_sde``."""
    equation = Coefficients(problem, jnp)

    def drift(x: jax.Array, t: jax.Array) -> jax.Array:
        return equation.drift(t, x[:, None])[:, 0]

    def diffusion(x: jax.Array, t: jax.Array) -> jax.Array:
        return jnp.diagonal(equation.diffusion(t, x[:, None])[..., 0])

    def one(x: jax.Array, t: jax.Array, h: jax.Array, *numbers: jax.Array) -> jax.Array:
        made, noise = getattr(tinydiffeq, solver)(), normals(*numbers)
        return tinydiffeq.solve_sde(drift, diffusion, made, t, t + h, x, n_steps=1, noise=noise).xs

    return vectorised(one)


def sdae_step(problem: DelaySDAE) -> Compiled:
    """Return the step of ``solve_semi_explicit_sdae``, with a last row that is 1 if the step was solved."""
    d = problem.dimension

    def field(formula: Callable[..., Any]) -> Callable[..., jax.Array]:
        def evaluated(x: jax.Array, y: jax.Array, t: jax.Array) -> jax.Array:
            time, given, known = (Foreign(value, jnp) for value in (t, x[:, None], y[:, None]))
            return jnp.ravel(formula(time, given, given, known).array)

        return evaluated

    def one(state: jax.Array, t: jax.Array, h: jax.Array, dW: jax.Array) -> jax.Array:
        fields, made = map(field, (problem.drift, problem.diffusion, problem.constraint)), known(dW)
        ends, begin = (t, t + h), (state[:d], state[d:])
        # The noise comes from the solver argument, so the random key is unused.
        end = tinydiffeq.solve_semi_explicit_sdae(*fields, made, *ends, *begin, key=jax.random.key(0), n_steps=1)
        return jnp.concatenate([end.ys, end.zs, jnp.atleast_1d(end.ok).astype(state.dtype)])

    return vectorised(one)


def known(dW: jax.Array) -> Any:
    """Return Euler's method with a given increment."""

    class Known(tinydiffeq.EulerMaruyama):  # type: ignore[misc]
        def sample_noise(self, *_: Any) -> Any:
            return normals(dW)

    return Known()


def normals(dW: jax.Array, H: jax.Array | None = None) -> Any:
    """Return dW, or dW and sqrt(12) H for the solver of order 1.5, each with a leading axis of one step."""
    return dW[None] if H is None else (dW[None], jnp.sqrt(12.0) * H[None])
