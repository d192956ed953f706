"""Schemes that are wrong in a region of the states, where runs are for a part of their time."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, DelaySDAE, DelayState, Increment, Parts, Problem, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays.lagged_algebraic_theta import LaggedAlgebraicTheta
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2

# Schemes that are wrong in a region of the states, or never leave one: runs are there for a part of their time.


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


class CutEuler(Cut, EulerMaruyama):
    """Euler-Maruyama whose components are cut at a bound."""

    name: ClassVar[str] = "planted-em-cut"


@dataclass(frozen=True)
class CutHeun(Cut, Heun):
    """Heun's scheme whose components are cut at a bound."""

    bound: float = 2.7

    name: ClassVar[str] = "planted-heun-cut"


class CutPlaten(Cut, PlatenWeak2):
    """Platen's scheme whose components are cut at a bound."""

    name: ClassVar[str] = "planted-platen-cut"


# Schemes that are right where most states are: the others are told by how far they are out.


@dataclass(frozen=True)
class FarDrift(EulerMaruyama):
    """Euler-Maruyama with half of the drift where a component is larger than the start by some factor.

    Attributes
    ----------
    factor : float
    """

    factor: float = 1.5

    name: ClassVar[str] = "planted-em-far"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        bound = self.factor * np.abs(problem.initial(1)).max()
        share = np.where(np.abs(state).max(axis=0) > bound, 0.5, 1.0)
        return Step(state + h * share * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


class Clipped(EulerMaruyama):
    """Euler-Maruyama whose states are cut at twice the start."""

    name: ClassVar[str] = "planted-em-clipped"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        bound = 2.0 * np.abs(problem.initial(1)).max()
        return Step(np.clip(super().step(problem, state, t, h, noise).state, -bound, bound))


# Schemes that carry something along and do not renew it in a region: whoever sets it right anew sees no bug.


class Remembering(NamedTuple):
    """x, and the drift there as the last step has left it, both of shape (d, P)."""

    x: Array
    drift: Array


@dataclass(frozen=True)
class StaleDrift(EulerMaruyama):
    """x+ = x + h m + B(t, x) dW with m+ = f(t + h, x+), but for m+ = m where |x_1+| is between two bounds.

    Attributes
    ----------
    low, high : float
    """

    low: float = 1.3
    high: float = 10.0

    name: ClassVar[str] = "planted-em-stale"

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembering:
        """Return a state with the drift there."""
        return Remembering(state, np.array(np.broadcast_to(problem.drift(t, state), state.shape)))

    def parts(self, problem: SDE, state: Remembering) -> Parts:
        """Return x alone."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Remembering, t: float, h: float, noise: Increment) -> Step:
        """Make one step; x has shape (d, P)."""
        x = state.x + h * state.drift + problem.diffused(t, state.x, noise.dW)
        stale = (self.low < np.abs(x[0])) & (np.abs(x[0]) < self.high)
        return Step(Remembering(x, np.where(stale, state.drift, problem.drift(t + h, x))))


@dataclass(frozen=True)
class Unsolved(Scheme):
    """A scheme whose algebraic component is kept where |x_1| is larger than a bound.

    Attributes
    ----------
    bound : float
    """

    bound: float = 1.2

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step = super().step(problem, state, t, h, noise)
        new = step.state
        return step._replace(state=new._replace(y=np.where(np.abs(new.x[0]) > self.bound, state.y, new.y)))


@dataclass(frozen=True)
class UnsolvedTheta(Unsolved, StochasticTheta):
    """The theta method whose algebraic component is kept where |x_1| is larger than a bound."""

    name: ClassVar[str] = "planted-theta-unsolved"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)


@dataclass(frozen=True)
class UnsolvedLagged(Unsolved, LaggedAlgebraicTheta):
    """The theta method with the old y, which is kept where |x_1| is larger than a bound."""

    name: ClassVar[str] = "planted-lagged-unsolved"


BUGS = [
    Planted("EM: drift 20 % off in a strip", RegionScaled(drift=1.2), "gbm"),
    Planted("EM: noise 10 % off in a strip", RegionScaled(noise_share=0.9), "gbm"),
    Planted("EM: noise 10 % off beyond a well", RegionScaled(high=10.0, noise_share=1.1), "double-well"),
    Planted("EM: no drift near the hill", RegionScaled(-0.03, 0.08, 0.0), "double-well"),
    Planted("Milstein: Euler far below", EulerBelow(), "hyperbolic[x_0=-1]"),
    Planted("EM: states cut at 1.5 in a double well", CutEuler(1.5), "double-well"),
    Planted("EM: states cut at 1.2 in one well", CutEuler(1.2), "ou"),
    Planted("Heun: states cut", CutHeun(), "gbm"),
    Planted("Platen: states cut at 1.5", CutPlaten(1.5), "double-well"),
    Planted("EM: half the drift far out", FarDrift(), "linear-test"),
    Planted("EM: half the drift far out, of a pendulum", FarDrift(), "angle-pendulum"),
    Planted("EM: states are cut far out", Clipped(), "gbm"),
    Planted("EM: remembered drift not renewed far out", StaleDrift(), "ou"),
    Planted("EM: remembered drift not renewed far out in a double well", StaleDrift(), "double-well"),
    Planted("EM: remembered drift not renewed in a strip", StaleDrift(0.6, 0.9), "gbm"),
    Planted("EM: remembered drift not renewed in a long run", StaleDrift(0.9), "ou[horizon=4]"),
    Planted("theta: y not solved for far out", UnsolvedTheta(), "gbm-algebraic"),
    Planted("lagged theta: y not solved for far out", UnsolvedLagged(), "gbm-algebraic"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
