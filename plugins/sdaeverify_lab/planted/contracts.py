"""Schemes that break the contract of a step, or are not exact on the trivial equations."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

from ._within import ScaledEuler

# Euler-Maruyama whose step is not a pure function of its arguments for each path, without effect on orders.


CALLS: list[float] = []


class HiddenState(EulerMaruyama):
    """Every second call negates the increment, so that repeated calls of a step differ."""

    name: ClassVar[str] = "planted-em-hidden-state"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        CALLS.append(t)
        return super().step(problem, state, t, h, noise._replace(dW=(-1.0) ** len(CALLS) * noise.dW))


class OwnNoise(EulerMaruyama):
    """Draws the same increments in each step, because the generator is reseeded."""

    name: ClassVar[str] = "planted-em-own-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        own = np.sqrt(h) * np.random.default_rng(0).standard_normal(noise.dW.shape)
        return super().step(problem, state, t, h, noise._replace(dW=own))


class WritesIntoState(EulerMaruyama):
    """x += f h and then x += B dW at the new x, in the caller's array."""

    name: ClassVar[str] = "planted-em-in-place"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        x += h * problem.drift(t, x)
        x += apply(problem.diffusion(t, x), noise.dW)
        return Step(x)


class FirstPathForAll(EulerMaruyama):
    """The drift of the first path of the batch is used for all paths."""

    name: ClassVar[str] = "planted-em-stale-batch"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f = problem.drift(t, state[:, :1])
        return Step(state + h * f + apply(problem.diffusion(t, state), noise.dW))


class SharedTaming(EulerMaruyama):
    """Drift f/(1 + h max |f|) with the maximum over all paths of the batch: right order, but coupled paths."""

    name: ClassVar[str] = "planted-em-batch-maximum"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f = problem.drift(t, state)
        return Step(state + h * f / (1.0 + h * np.abs(f).max()) + apply(problem.diffusion(t, state), noise.dW))


# Euler-Maruyama that is inexact on the trivial equations, possibly without effect on orders.


class TwiceAStep(EulerMaruyama):
    """Two steps of size h instead of one."""

    name: ClassVar[str] = "planted-em-double-step"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make two steps."""
        once = super().step(problem, state, t, h, noise).state
        return super().step(problem, once, t + h, h, noise)


class SinglePrecision(EulerMaruyama):
    """Rounds every state to single precision."""

    name: ClassVar[str] = "planted-em-single-precision"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = super().step(problem, state, t, h, noise).state
        return Step(new.astype(np.float32).astype(float))


BUGS = [
    Planted("EM: a counter outside the state", HiddenState(), "gbm"),
    Planted("EM: a generator that is seeded anew in each step", OwnNoise(), "gbm"),
    Planted("EM: writes into the state it is given", WritesIntoState(), "gbm"),
    Planted("EM: drift of the first path for the whole batch", FirstPathForAll(), "gbm"),
    Planted("EM: taming by the largest drift of the batch", SharedTaming(), "gbm"),
    Planted("EM: paths treated by their place in the batch", ScaledEuler("path", 200, drift=0.95), "gbm"),
    Planted("EM: two steps in place of one", TwiceAStep(), "gbm"),
    Planted("EM: first step left out", ScaledEuler("step", high=2, drift=0.0, noise_share=0.0), "gbm"),
    Planted("EM: states rounded to single precision", SinglePrecision(), "gbm"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
