"""A plugin whose scheme never ends its step."""

import time
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl

from ._euler import Euler


class Hanging(Euler):
    """Waits forever."""

    name: ClassVar[str] = "hanging-euler"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Wait."""
        while True:
            time.sleep(1.0)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Hanging()]
