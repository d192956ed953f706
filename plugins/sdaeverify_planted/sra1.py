"""SRA1 with a wrong time integral Z of the noise; it claims strong order 3/2."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.sra1 import SRA1


@dataclass(frozen=True)
class ScaledArea(SRA1):
    """Z/h = dW/2 + factor H, where the factor is 1."""

    factor: float = 2.0

    name: ClassVar[str] = "planted-sra1-area"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        return super().step(problem, state, t, h, noise._replace(H=self.factor * noise.H))


class AreaForIntegral(SRA1):
    """H in place of Z/h = H + dW/2."""

    name: ClassVar[str] = "planted-sra1-area-for-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, _OnlyArea(*noise))


class _OnlyArea(Increment):
    """An increment whose time integral lacks the part of dW."""

    __slots__ = ()

    def time_integral(self, h: float) -> Array:
        """Return h H, shape (l, P)."""
        assert self.H is not None
        return h * self.H


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs = {"H for Z/h": AreaForIntegral(), "H doubled": ScaledArea(2.0), "H sign": ScaledArea(-1.0)}
    return [Planted(bug=f"SRA1: {bug}", scheme=scheme, problem="double-well") for bug, scheme in bugs.items()]
