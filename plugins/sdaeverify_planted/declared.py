"""Schemes that declare what makes nodes say nothing of them, jumps or areas, and are wrong in plain sight."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein_areas import MilsteinAreas


@dataclass(frozen=True)
class JumpingEuler(EulerMaruyama):
    """x+ = x + h f(t, a x) + B(t, b x) dW that says its steps jump as functions of their noise.

    With constant coefficients, as in the problems that every scheme solves exactly, nothing of a and b is seen.

    Attributes
    ----------
    of_drift, of_noise : float
        a and b.
    """

    of_drift: float = 1.0
    of_noise: float = 1.0

    name: ClassVar[str] = "planted-em-jumps"
    jumps: ClassVar[bool] = True

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        kick = problem.diffused(t, self.of_noise * state, noise.dW)
        return Step(state + h * problem.drift(t, self.of_drift * state) + kick)


class AreaEuler(JumpingEuler):
    """The same that says it needs areas, and makes no use of them."""

    name: ClassVar[str] = "planted-em-areas"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})
    jumps: ClassVar[bool] = False


@dataclass(frozen=True)
class ScaledAreas(MilsteinAreas):
    """Milstein's scheme with scaled areas, or with its drift at a x or its noise at b x.

    Attributes
    ----------
    areas : float
        What areas are multiplied by.
    of_drift, of_noise : float
        a and b.
    """

    areas: float = 1.02
    of_drift: float = 1.0
    of_noise: float = 1.0

    name: ClassVar[str] = "planted-milstein-areas"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        given = noise if noise.A is None else noise._replace(A=self.areas * noise.A)
        euler = JumpingEuler(self.of_drift, self.of_noise).step(problem, state, t, h, noise).state
        return Step(super().step(problem, state, t, h, given).state + euler - problem.euler(t, state, h, noise))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    jumps = Planted(bug="EM, declares jumps: noise at 1.003 x", scheme=JumpingEuler(1.0, 1.003), problem="gbm")
    areas = Planted(bug="EM, declares areas: noise at 1.003 x", scheme=AreaEuler(1.0, 1.003), problem="levy-area")
    lost = Planted(bug="Milstein with areas: areas x 1.02", scheme=ScaledAreas(), problem="levy-area")
    return [
        jumps,
        replace(jumps, bug="EM, declares jumps: drift at 0.98 x", scheme=JumpingEuler(0.98)),
        replace(jumps, bug="EM, declares jumps: drift at 0.98 x, to rest", scheme=JumpingEuler(0.98), problem="ou"),
        areas,
        replace(areas, bug="EM, declares areas: drift at 0.98 x", scheme=AreaEuler(0.98)),
        lost,
        replace(lost, bug="Milstein with areas: areas x 0.9", scheme=ScaledAreas(0.9)),
        replace(lost, bug="Milstein with areas: noise at 1.003 x", scheme=ScaledAreas(1.0, 1.0, 1.003)),
        replace(lost, bug="Milstein with areas: drift at 0.98 x", scheme=ScaledAreas(1.0, 0.98)),
    ]
