"""MALA that accepts too much; it claims that its stationary means are exact."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Planted, Step, hookimpl
from sdaeverify_schemes.mala import MALA, density_ratio


@dataclass(frozen=True)
class AcceptsAll(MALA):
    """Without rejection: Euler-Maruyama, smooth in its noise, whose bias on `ou` is 0.035 at h = 1/4."""

    name: ClassVar[str] = "planted-mala-accepts-all"
    jumps: ClassVar[bool] = False
    claims: ClassVar[tuple[Claim, ...]] = (replace(MALA.claims[0], bound=0.01),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class WithoutProposal(MALA):
    """Accepted by the ratio of densities alone, as if the step were symmetric."""

    name: ClassVar[str] = "planted-mala-without-proposal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        y = state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW)
        return Step(np.where(np.log(noise.uniform(h)) < density_ratio(problem, t, state, y), y, state))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="MALA: without rejection", scheme=AcceptsAll(), problem="ou"),
        Planted(bug="MALA: the proposal's density left out", scheme=WithoutProposal(), problem="ou"),
    ]
