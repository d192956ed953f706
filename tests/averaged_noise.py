"""The method of Leimkuhler and Matthews, which remembers its last increment: right in law, and off on each path."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Parts, Scheme, Step

ADDITIVE = frozenset({"additive-noise", "no-delay"})


class Remembered(NamedTuple):
    """x, and the increment of the step before: zero at the start."""

    x: Array
    dW: Array


@dataclass(frozen=True)
class LeimkuhlerMatthews(Scheme):
    """x+ = x + h f(x) + B (dW_n + dW_{n+1})/2 for additive noise, dW_{n+1} being drawn in this step.

    With post-processing (Vilmart 2015) it is z+ = z + h f(x) + B dW, x = z + B dW/2: of weak order 1, and of order 2
    in the invariant measure. A path is half an increment behind.

    Attributes
    ----------
    strength : float
        What the noise is multiplied by: 1 in the method.
    """

    strength: float = 1.0

    name: ClassVar[str] = "leimkuhler-matthews"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, when=ADDITIVE, source="Leimkuhler & Matthews 2013"),
        Claim(measure="invariant", value=2.0, when=ADDITIVE, source="Leimkuhler, Matthews & Tretyakov 2014"),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse noise other than c dW with a number c: there is no such invariant measure."""
        if not problem.traits >= ADDITIVE:
            return "the noise is not additive"
        B = problem.diffusion(0.0, problem.initial(1))[..., 0]
        scalar = B.shape[0] == B.shape[1] and np.array_equal(B, B[0, 0] * np.eye(len(B)))
        return "" if scalar else "the noise is not the same in each component"

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembered:
        """Return a state before which there was no increment."""
        return Remembered(state, np.zeros((problem.noise_dim, state.shape[-1])))

    def parts(self, problem: SDE, state: Remembered) -> Parts:
        """Return x without the memory."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, before = state
        kick = problem.diffused(t, x, 0.5 * self.strength * (before + noise.dW))
        return Step(Remembered(x + h * problem.drift(t, x) + kick, noise.dW.copy()))
