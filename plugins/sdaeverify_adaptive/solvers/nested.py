"""Heun's scheme on nested meshes, which skip no time at which the path was evaluated."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl

from ..contract import Adaptive
from ..marching import Front, Marching, Stretch, Tried
from .embedded import heun

SOURCE = "the limit by Gaines & Lyons 1997 and Foster & Jelincic 2023, nested meshes; the rate is measured"


class HeunNested(Marching):
    """Heun's scheme on dyadic intervals: a rejected interval is halved, and its end point is visited later.

    After a step, the next interval is twice as long if it begins at a multiple of twice its length and the error was
    below a quarter. Two dyadic intervals are nested or disjoint. Therefore no step passes over the end point of a
    rejected step.
    """

    name: ClassVar[str] = "heun-nested"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, source=SOURCE),
        Claim(measure="tolerance-steps", value=0.5, source=SOURCE),
    )
    source: ClassVar[str] = "Gaines & Lyons 1997, Variable step size control"

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        return heun(problem, step)

    def resized(self, moved: Front, error: Array, before: Array, accepted: Array) -> Array:
        """Return half the length of a rejected step, twice that of a step with a small error, else the same."""
        double = accepted & (error < 0.25) & (moved.here.tick % (2 * moved.size) == 0)
        size = np.where(accepted, np.where(double, 2 * moved.size, moved.size), moved.size // 2)
        return np.clip(size, self.shortest, self.longest)


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register the solver."""
    return [HeunNested()]
