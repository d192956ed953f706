"""MALA that accepts too much or proposes from another law; it claims that its stationary means are exact."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.mala import MALA, density_ratio, log_ratio


class AcceptsAll(MALA):
    """Without rejection: Euler-Maruyama, smooth in its noise, whose bias on `ou` is 0.035 at h = 1/4."""

    name: ClassVar[str] = "planted-mala-accepts-all"
    jumps: ClassVar[bool] = False

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        return Step(problem.euler(t, state, h, noise))


class WithoutProposal(MALA):
    """Accepted by the ratio of densities alone, as if the step were symmetric."""

    name: ClassVar[str] = "planted-mala-without-proposal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        y = problem.euler(t, state, h, noise)
        return Step(np.where(np.log(noise.uniform(h)) < density_ratio(problem, t, state, y), y, state))


class TooWide(MALA):
    """A proposal with a tenth too much variance, accepted as the right one: 0.023 too much E x^2 on `ou`."""

    name: ClassVar[str] = "planted-mala-too-wide"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        kick = np.sqrt(1.1) * problem.diffused(t, state, noise.dW)
        y = state + h * problem.drift(t, state) + kick
        return Step(np.where(np.log(noise.uniform(h)) < log_ratio(problem, t, h, state, y), y, state))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="MALA: without rejection", scheme=AcceptsAll(), problem="ou"),
        Planted(bug="MALA: without rejection, where it diverges", scheme=AcceptsAll(), problem="double-well"),
        Planted(bug="MALA: a tenth too much variance in the proposal", scheme=TooWide(), problem="ou"),
        Planted(bug="MALA: the proposal's density left out", scheme=WithoutProposal(), problem="ou"),
    ]
