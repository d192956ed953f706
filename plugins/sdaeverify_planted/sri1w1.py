"""SRI1W1 with a wrong integral of the noise or a stage in the wrong place; it claims strong order 3/2."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.sri1w1 import SRI1W1, stages


class WithoutArea(SRI1W1):
    """Z = h dW/2: the part of int W ds that dW does not know is left out."""

    name: ClassVar[str] = "planted-sri1w1-without-area"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(H=np.zeros_like(noise.dW)))


class FirstAreaForAll(SRI1W1):
    """H of the first Brownian motion takes the place of all."""

    name: ClassVar[str] = "planted-sri1w1-first-area-for-all"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        return super().step(problem, state, t, h, noise._replace(H=np.repeat(noise.H[:1], len(noise.H), axis=0)))


class WithoutTripleIntegral(SRI1W1):
    """The term of I_111 is left out."""

    name: ClassVar[str] = "planted-sri1w1-without-triple-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        *_, thrice = stages(problem, state, t, h, problem.drift(t, state))
        dW = noise.dW
        return Step(super().step(problem, state, t, h, noise).state - thrice * (dW**3 - 3.0 * h * dW) / (6.0 * h))


class StratonovichIntegral(SRI1W1):
    """The double integral is dW^2/2 in place of (dW^2 - h)/2."""

    name: ClassVar[str] = "planted-sri1w1-stratonovich-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        _, _, twice, _ = stages(problem, state, t, h, problem.drift(t, state))
        return Step(super().step(problem, state, t, h, noise).state + 0.5 * np.sqrt(h) * twice)


class OldTimes(SRI1W1):
    """All stages take the coefficients at the beginning of the step."""

    name: ClassVar[str] = "planted-sri1w1-old-times"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        held = replace(
            problem,
            drift=lambda _, x: problem.drift(t, x),
            diffusion=lambda _, x: problem.diffusion(t, x),
            diffusion_derivative=None,
        )
        return super().step(held, state, t, h, noise)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="SRI1W1: H left out", scheme=WithoutArea(), problem="hyperbolic"),
        Planted(bug="SRI1W1: H of the first motion for all", scheme=FirstAreaForAll(), problem="hyperbolic-pair"),
        Planted(bug="SRI1W1: I_111 left out", scheme=WithoutTripleIntegral(), problem="spiral"),
        Planted(bug="SRI1W1: Stratonovich's double integral", scheme=StratonovichIntegral(), problem="hyperbolic"),
        Planted(bug="SRI1W1: stages at the old time", scheme=OldTimes(), problem="growing-volatility"),
    ]
