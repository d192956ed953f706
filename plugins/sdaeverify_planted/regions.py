"""Schemes that are wrong in a region of the states, or never leave one: runs are there for a part of their time."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2


@dataclass(frozen=True)
class RegionScaled(EulerMaruyama):
    """Euler-Maruyama with a scaled drift or noise on paths whose first component is in an interval.

    Attributes
    ----------
    low, high : float
    drift, noise_share : float
        What they are multiplied by there.
    """

    low: float = 1.2
    high: float = 1.5
    drift: float = 1.0
    noise_share: float = 1.0

    name: ClassVar[str] = "planted-em-region"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        inside = (self.low < state[0]) & (state[0] < self.high)
        drift, loud = np.where(inside, self.drift, 1.0), np.where(inside, self.noise_share, 1.0)
        return Step(state + drift * h * problem.drift(t, state) + loud * problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class EulerBelow(Milstein):
    """Milstein's scheme that is Euler's where the first component is below a bound.

    Attributes
    ----------
    bound : float
    """

    bound: float = -1.5

    name: ClassVar[str] = "planted-milstein-region"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        euler, right = EulerMaruyama().step(problem, state, t, h, noise), super().step(problem, state, t, h, noise)
        return Step(np.where(state[0] < self.bound, euler.state, right.state))


@dataclass(frozen=True)
class Cut(Scheme):
    """A scheme whose components are cut at a bound after each step.

    Attributes
    ----------
    bound : float
    """

    bound: float = 2.0

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return Step(np.clip(super().step(problem, state, t, h, noise).state, -self.bound, self.bound))


@dataclass(frozen=True)
class CutEuler(Cut, EulerMaruyama):
    """Euler-Maruyama whose components are cut at a bound."""

    name: ClassVar[str] = "planted-em-cut"


@dataclass(frozen=True)
class CutHeun(Cut, Heun):
    """Heun's scheme whose components are cut at a bound."""

    bound: float = 2.7

    name: ClassVar[str] = "planted-heun-cut"


@dataclass(frozen=True)
class CutPlaten(Cut, PlatenWeak2):
    """Platen's scheme whose components are cut at a bound."""

    name: ClassVar[str] = "planted-platen-cut"


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    drift = Planted(bug="EM: drift 20 % off in a strip", scheme=RegionScaled(drift=1.2), problem="gbm")
    return [
        drift,
        replace(drift, bug="EM: noise 10 % off in a strip", scheme=RegionScaled(noise_share=0.9)),
        replace(
            drift,
            bug="EM: noise 10 % off beyond a well",
            scheme=RegionScaled(1.2, 10.0, noise_share=1.1),
            problem="double-well",
        ),
        replace(
            drift,
            bug="EM: no drift near the hill",
            scheme=RegionScaled(-0.03, 0.08, drift=0.0),
            problem="double-well",
        ),
        Planted(bug="Milstein: Euler far below", scheme=EulerBelow(), problem="hyperbolic[x_0=-1]"),
        Planted(bug="EM: states cut at 1.5 in a double well", scheme=CutEuler(1.5), problem="double-well"),
        Planted(bug="EM: states cut at 1.2 in one well", scheme=CutEuler(1.2), problem="ou"),
        Planted(bug="Heun: states cut", scheme=CutHeun(), problem="gbm"),
        Planted(bug="Platen: states cut at 1.5", scheme=CutPlaten(1.5), problem="double-well"),
    ]
