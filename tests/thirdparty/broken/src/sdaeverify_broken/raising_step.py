"""A plugin whose scheme raises in its step."""

from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl

from ._euler import Euler


class Raising(Euler):
    """No step at all."""

    name: ClassVar[str] = "raising-euler"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Raise."""
        raise ZeroDivisionError("a step that cannot be made")


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Raising()]
