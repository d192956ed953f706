"""How many chains there are, and how long they run."""

from typing import Any, NamedTuple

import numpy as np

from ...noise.brownian import Source

LEVELS = 4
# Fewer levels than these finest ones tell no order.
NEEDED_LEVELS = 3
# Groups of chains: Student's law with 31 degrees of freedom has light tails.
GROUPS = 32
# Relaxation times that are burnt in at least; the first look records as many.
BURN_IN = 10.0
SEGMENTS = 10
# Steps, all levels together, that a plan may take.
MOST_STEPS = 20_000


class Plan(NamedTuple):
    """How many chains there are, and how long they run.

    Attributes
    ----------
    h : float
        Coarsest step size; halved until no chain of a pilot run blows up.
    relaxation : float
        Time in which the solution forgets its start by a factor e.
    seed : int
    looks : int
        How often at most the records are judged, each time twice as long.
    paired, wide : int
        Chains that run at all step sizes on the same noise, and at the coarsest alone; multiples of `GROUPS`.
    """

    h: float
    relaxation: float
    seed: int
    looks: int = 6
    paired: int = 32 * GROUPS
    wide: int = 256 * GROUPS

    def steps(self, times: float) -> int:
        """Return the coarsest steps of some relaxation times, a multiple of `SEGMENTS`."""
        return SEGMENTS * int(np.ceil(times * self.relaxation / (SEGMENTS * self.h)))

    def source(self, view: Any, purpose: str, chains: int) -> Source:
        """Return where the noise of some chains comes from."""
        return Source(self.seed, f"{view.source}|chains|{purpose}", 0, chains)

    def affords(self, steps: int) -> bool:
        """Tell whether so many coarsest steps, with those of the finer levels inside them, may be taken."""
        return steps * ((1 << LEVELS) - 1) <= MOST_STEPS

    @property
    def affordable(self) -> "Plan":
        """The plan with as many looks as can be afforded, at least one."""
        burnt = self.steps(BURN_IN)
        looks = [look for look in range(2, self.looks + 1) if self.affords(burnt + burnt * 2 ** (look - 1))]
        return self._replace(looks=max(looks, default=1))
