"""One step of a diffrax solver as a compiled function of arrays with paths last."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp

from sdaeverify import SDE, Langevin
from sdaeverify_bridges.kit import Coefficients, Compiled, Foreign, vectorised

from ._reversible import split_memory

RECORDS = {1: diffrax.BrownianIncrement, 2: diffrax.SpaceTimeLevyArea, 3: diffrax.SpaceTimeTimeLevyArea}
Terms = Callable[["KnownStep"], diffrax.AbstractTerm]


class KnownStep(diffrax.AbstractBrownianPath):
    """Brownian path that returns the given increment of one step, regardless of the requested times.

    Attributes
    ----------
    h : float
        Length of the step.
    numbers : tuple of array, shape (l,)
        W and, if given, H and K.
    """

    h: jax.Array
    numbers: tuple[jax.Array, ...]
    levy_area: ClassVar[Any] = None
    t0: ClassVar[float] = -jnp.inf
    t1: ClassVar[float] = jnp.inf

    def evaluate(self, t0: Any, t1: Any = None, left: bool = True, use_levy: bool = False) -> Any:
        """Return W, or the record of all given variables."""
        return RECORDS[len(self.numbers)](self.h, *self.numbers) if use_levy else self.numbers[0]


def sde_step(solver: str, problem: SDE, *, stratonovich: bool) -> Compiled:
    """Return the step of a solver for dx = f dt + B dW."""
    equation = Coefficients(problem, jnp, stratonovich)
    return one_step(getattr(diffrax, solver)(), partial(sde_terms, equation))


def sde_terms(equation: Coefficients, path: KnownStep) -> diffrax.AbstractTerm:
    """Return the terms of an equation on a path."""

    def drift(t: jax.Array, y: jax.Array, _: Any) -> jax.Array:
        return equation.drift(t, y[:, None])[:, 0]

    def diffusion(t: jax.Array, y: jax.Array, _: Any) -> jax.Array:
        return equation.diffusion(t, y[:, None])[..., 0]

    return diffrax.MultiTerm(diffrax.ODETerm(drift), diffrax.ControlTerm(diffusion, path))


def langevin_step(solver: str, problem: Langevin) -> Compiled:
    """Return the step of a solver for dx = v dt, dv = -gamma v dt - u grad f(x) dt + sqrt(2 gamma u) dW.

    With u = sigma^2/(2 gamma), the force is -u grad f.
    """
    n, gamma = problem.noise_dim, problem.friction
    u = problem.strength**2 / (2.0 * gamma)

    def gradient(x: jax.Array, _: Any) -> jax.Array:
        return -problem.force(Foreign(x[:, None], jnp)).array[:, 0] / u

    def terms(path: KnownStep) -> diffrax.AbstractTerm:
        drift = diffrax.UnderdampedLangevinDriftTerm(gamma, u, gradient)
        return diffrax.MultiTerm(drift, diffrax.UnderdampedLangevinDiffusionTerm(gamma, u, path))

    # Below this product of friction and step size, coefficients of a step are computed by series. The value is the
    # one recommended in the documentation for double precision.
    found = getattr(diffrax, solver)(taylor_threshold=0.01)
    return one_step(found, terms, lambda y: (y[:n], y[n:]), jnp.concatenate)


def reversible_step(problem: SDE) -> Compiled:
    """Return the step of the reversible Heun method, whose memory is part of the state."""
    equation, solver = Coefficients(problem, jnp, stratonovich=True), diffrax.ReversibleHeun()

    def one(memory: jax.Array, t: jax.Array, h: jax.Array, dW: jax.Array) -> jax.Array:
        x, z, F, B = split_memory(problem, memory)
        terms = sde_terms(equation, KnownStep(h, (dW,)))
        x, _, _, (z, (F, B)), _ = solver.step(terms, t, t + h, x, None, (z, (F, B)), made_jump=False)
        return jnp.concatenate([x, z, F, B.reshape(-1)])

    return vectorised(one)


def one_step(
    solver: Any,
    terms: Terms,
    taken: Callable[[jax.Array], Any] = lambda y: y,
    joined: Callable[[Any], jax.Array] = lambda y: y,
) -> Compiled:
    """Return the step of a solver for all paths at once, with the solver initialised at each step."""

    def one(y: jax.Array, t: jax.Array, h: jax.Array, *numbers: jax.Array) -> jax.Array:
        equation, state = terms(KnownStep(h, numbers)), taken(y)
        memory = solver.init(equation, t, t + h, state, None)
        return joined(solver.step(equation, t, t + h, state, None, memory, made_jump=False)[0])

    return vectorised(one)
