"""A plugin whose scheme takes all the memory it can get."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl

from ._euler import Euler

# 2 GiB a piece, 16 GiB in all: what it is run with has to stop it, but no machine should be lost if it does not.
PIECE, PIECES = 2**28, 8


class Hoarding(Euler):
    """Fills the memory."""

    name: ClassVar[str] = "hoarding-euler"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Take more and more."""
        hoard = [np.ones(PIECE) for _ in range(PIECES)]
        raise MemoryError(f"{len(hoard)} pieces of memory were to be had")


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Hoarding()]
