"""Schemes that are right where most states are: the others are told by how far they are out."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama


@dataclass(frozen=True)
class FarDrift(EulerMaruyama):
    """Euler-Maruyama with half of the drift where a component is larger than the start by some factor.

    Attributes
    ----------
    factor : float
    """

    factor: float = 1.5

    name: ClassVar[str] = "planted-em-far"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        bound = self.factor * np.abs(problem.initial(1)).max()
        share = np.where(np.abs(state).max(axis=0) > bound, 0.5, 1.0)
        return Step(state + h * share * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


class Clipped(EulerMaruyama):
    """Euler-Maruyama whose states are cut at twice the start."""

    name: ClassVar[str] = "planted-em-clipped"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        bound = 2.0 * np.abs(problem.initial(1)).max()
        return Step(np.clip(super().step(problem, state, t, h, noise).state, -bound, bound))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    half = "EM: half the drift far out"
    return [
        Planted(bug=half, scheme=FarDrift(), problem="linear-test"),
        Planted(bug=f"{half}, of a pendulum", scheme=FarDrift(), problem="angle-pendulum"),
        Planted(bug="EM: states are cut far out", scheme=Clipped(), problem="gbm"),
    ]
