"""Euler-Maruyama with wrong noise, wrong drift or a wrong limit; it claims what Euler-Maruyama keeps."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun, stratonovich


class WithoutItoCorrection(EulerMaruyama):
    """x+ = x + (f - (1/2) sum_j DB_j B_j) h + B dW: Ito's integral of the Stratonovich drift."""

    name: ClassVar[str] = "planted-em-stratonovich-drift"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        F, B = stratonovich(problem, t, state)
        return Step(state + h * F + apply(B, noise.dW))


class HeunOfItoDrift(Heun):
    """Heun's scheme with Ito's drift f: it tends to the Stratonovich solution of the same coefficients."""

    name: ClassVar[str] = "planted-heun-ito-drift"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        y = state + h * f + apply(B, noise.dW)
        both = apply(B, noise.dW) + apply(problem.diffusion(t + h, y), noise.dW)
        return Step(state + 0.5 * (h * (f + problem.drift(t + h, y)) + both))


@dataclass(frozen=True)
class WrongVariance(EulerMaruyama):
    """Noise of variance (1 + excess) h."""

    excess: float = 0.05

    name: ClassVar[str] = "planted-em-variance"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(1.0 + self.excess) * noise.dW))


class NoiseOfSizeH(EulerMaruyama):
    """Noise h xi in place of sqrt(h) xi, xi standard normal."""

    name: ClassVar[str] = "planted-em-noise-of-size-h"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(h) * noise.dW))


class ScaledDrift(EulerMaruyama):
    """Drift 0.98 f."""

    name: ClassVar[str] = "planted-em-drift-0.98"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(super().step(problem, state, t, h, noise).state - 0.02 * h * problem.drift(t, state))


class ImplicitNoise(EulerMaruyama):
    """Theta = 1/2 in the noise, too: x+ = x + f h + (1/2) [B(x) + B(y)] dW with y = x + f h + B dW."""

    name: ClassVar[str] = "planted-em-theta-in-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        y = super().step(problem, state, t, h, noise).state
        change = apply(problem.diffusion(t + h, y) - problem.diffusion(t, state), noise.dW)
        return Step(y + 0.5 * change)


class ClippedNoise(EulerMaruyama):
    """Increments cut at one standard deviation: |dW| <= sqrt(h)."""

    name: ClassVar[str] = "planted-em-clipped-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.clip(noise.dW, -np.sqrt(h), np.sqrt(h))))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="EM: missing Ito correction", scheme=WithoutItoCorrection(), problem="gbm"),
        Planted(bug="EM: noise variance +5 %", scheme=WrongVariance(), problem="gbm"),
        Planted(bug="EM: noise variance +1 %", scheme=WrongVariance(0.01), problem="gbm"),
        Planted(bug="EM: h instead of sqrt(h) in the noise", scheme=NoiseOfSizeH(), problem="gbm"),
        Planted(bug="EM: drift x 0.98", scheme=ScaledDrift(), problem="gbm"),
        Planted(bug="EM: theta in the noise as well", scheme=ImplicitNoise(), problem="gbm"),
        Planted(bug="EM: noise clipped at one standard deviation", scheme=ClippedNoise(), problem="gbm"),
        Planted(bug="Heun: Ito drift in a Stratonovich scheme", scheme=HeunOfItoDrift(), problem="gbm"),
    ]
