"""Platen's scheme of weak order 2 for several noises with a wrong double integral; it claims weak order 2."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General


@dataclass(frozen=True)
class ScaledSigns(PlatenWeak2General):
    """V_rj times factor^2, where the factor is 1."""

    factor: float = 0.0

    name: ClassVar[str] = "planted-platen-general-signs"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        return super().step(problem, state, t, h, noise._replace(H=self.factor * noise.H))


class OneSign(PlatenWeak2General):
    """The sign of the first Brownian motion for all: V_12 = h, no random variable."""

    name: ClassVar[str] = "planted-platen-general-one-sign"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        return super().step(problem, state, t, h, noise._replace(H=np.repeat(noise.H[:1], len(noise.H), axis=0)))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs = {
        "without signs": ScaledSigns(0.0),
        "signs 10 % too small": ScaledSigns(0.9),
        "one sign for all": OneSign(),
    }
    return [Planted(bug=f"Platen-2, general: {bug}", scheme=s, problem="noncommuting") for bug, s in bugs.items()]
