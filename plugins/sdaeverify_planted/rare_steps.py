"""Schemes that are right in most of their steps: the others are told by their index, or by how late they are."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein


@dataclass(frozen=True)
class RareDrift(EulerMaruyama):
    """Euler-Maruyama that forgets the drift in one of so many steps.

    Attributes
    ----------
    every : int
    """

    every: int = 16

    name: ClassVar[str] = "planted-em-rare"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        if round(t / h) % self.every < self.every - 1:
            return super().step(problem, state, t, h, noise)
        return Step(state + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class LateDrift(EulerMaruyama):
    """Euler-Maruyama that forgets the drift from some part of the horizon on, or up to it.

    Attributes
    ----------
    since, until : float
        As parts of the horizon.
    """

    since: float = 0.9
    until: float = 1.0

    name: ClassVar[str] = "planted-em-late"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        if not self.since * problem.horizon < t + h / 2 <= self.until * problem.horizon:
            return super().step(problem, state, t, h, noise)
        return Step(state + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class RareCorrection(Milstein):
    """Milstein's scheme that is Euler's in one of so many steps, with Milstein's order claimed.

    Attributes
    ----------
    every : int
    """

    every: int = 16

    name: ClassVar[str] = "planted-milstein-rare"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        of: Scheme = Milstein() if round(t / h) % self.every else EulerMaruyama()
        return of.step(problem, state, t, h, noise)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    rare = Planted(bug="EM: drift forgotten in every 16th step", scheme=RareDrift(), problem="double-well")
    late = Planted(bug="EM: drift forgotten in the last tenth", scheme=LateDrift(), problem="double-well")
    return [
        rare,
        replace(rare, bug="EM: drift forgotten in every 7th step", scheme=RareDrift(7)),
        replace(rare, bug="EM: drift forgotten in every 100th step", scheme=RareDrift(100)),
        replace(rare, bug="EM: drift forgotten in every 16th step of a moving force", problem="forced-ou"),
        late,
        replace(late, bug="EM: drift forgotten in between", scheme=LateDrift(0.5, 0.6)),
        Planted(bug="Milstein: Euler in every 16th step", scheme=RareCorrection(), problem="gbm"),
    ]
