"""A solver that halves its steps, as an author would write it."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl
from sdaeverify_adaptive import Adaptive
from sdaeverify_adaptive.marching import Front, Marching, Stretch, Tried
from sdaeverify_schemes.heun import stratonovich


class Halving(Marching):
    """Heun's scheme; a step is halved if it is rejected, and doubled after each one that is not."""

    name: ClassVar[str] = "halving"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, when=frozenset({"commutative-noise"}), source="measured"),
    )

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Return a step, and what it differs from Euler's."""
        t, h, dW = step.t, step.h, step.noise.dW
        F, B = stratonovich(problem, t, step.x)
        euler = step.x + h * F + np.einsum("dlp,lp->dp", B, dW)
        G, C = stratonovich(problem, t + h, euler)
        error = 0.5 * (h * (G - F) + np.einsum("dlp,lp->dp", C - B, dW))
        return Tried(euler + error, error)

    def resized(self, moved: Front, error: Array, before: Array, accepted: Array) -> Array:
        """Return the next length in ticks."""
        return np.clip(np.where(accepted, 2 * moved.size, moved.size // 2), 1, self.longest)


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register the solver."""
    return [Halving()]
