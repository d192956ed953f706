"""Milstein's scheme for one Brownian motion with a wrong correction; it claims Milstein's order."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.milstein import Milstein


@dataclass(frozen=True)
class ScaledCorrection(Milstein):
    """x+ = x + f h + B dW + factor DB B (dW^2 - h), where Milstein's factor is 1/2."""

    factor: float = 1.0

    name: ClassVar[str] = "planted-milstein-factor"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        euler = problem.euler(t, state, h, noise)
        correction = super().step(problem, state, t, h, noise).state - euler
        return Step(euler + 2.0 * self.factor * correction)


class WithoutH(Milstein):
    """Correction (1/2) DB B dW^2: its mean is (h/2) DB B."""

    name: ClassVar[str] = "planted-milstein-without-h"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        missing = 0.5 * h * problem.derivative_of_diffusion(t, state, problem.diffusion(t, state)[:, 0])[:, 0]
        return Step(super().step(problem, state, t, h, noise).state + missing)


class WithoutDerivative(Milstein):
    """Correction (1/2) B (dW^2 - h): b in place of b b'."""

    name: ClassVar[str] = "planted-milstein-without-derivative"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        B = problem.diffusion(t, state)
        return Step(problem.euler(t, state, h, noise) + 0.5 * B[:, 0] * (noise.dW**2 - h))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Milstein] = {
        "without -h": WithoutH(),
        "correction sign": ScaledCorrection(-0.5),
        "factor 1 instead of 1/2": ScaledCorrection(1.0),
        "factor .45": ScaledCorrection(0.45),
        "b instead of b b'": WithoutDerivative(),
    }
    return [Planted(bug=f"Milstein: {bug}", scheme=scheme, problem="gbm") for bug, scheme in bugs.items()]
