"""Heun's scheme on meshes that are nested: no time is skipped at which the path was seen."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl

from ..contract import Adaptive
from ..marching import Front, Marching, Stretch, Tried
from .embedded import heun

SOURCE = "the limit by Gaines & Lyons 1997 and Foster & Jelincic 2023, nested meshes; the rate is measured"


class HeunNested(Marching):
    """Heun's scheme on dyadic intervals: one that is rejected is halved, and its end is met in any case.

    After a step, the next interval is twice as long where it begins at a multiple of twice its length and the error
    was below a quarter. Two dyadic intervals lie inside of each other or do not meet: no step passes over a time at
    which a rejected one has ended.
    """

    name: ClassVar[str] = "heun-nested"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, source=SOURCE),
        Claim(measure="tolerance-steps", value=0.5, source=SOURCE),
    )
    source: ClassVar[str] = "Gaines & Lyons 1997, Variable step size control"

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Return a step that is tried, and the estimate of its error."""
        return heun(problem, step)

    def resized(self, moved: Front, error: Array, before: Array, accepted: Array) -> Array:
        """Return half of a length that was rejected, twice the length of a step with a small error, else the same."""
        double = accepted & (error < 0.25) & (moved.here.tick % (2 * moved.size) == 0)
        size = np.where(accepted, np.where(double, 2 * moved.size, moved.size), moved.size // 2)
        return np.clip(size, self.shortest, self.longest)


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register the solver."""
    return [HeunNested()]
