"""Schemes that are wrong in a region of the state space, which runs visit for a part of their time."""

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

from ._within import EulerWithin, ScaledEuler


class MilsteinBelow(EulerWithin, Milstein):
    """Milstein's scheme that is Euler-Maruyama in a region."""

    name: ClassVar[str] = "planted-milstein-region"


# Schemes that never leave a region, at whose boundary runs stay for a part of their time.


@dataclass(frozen=True)
class Cut(Scheme):
    """A scheme whose components are clipped at a bound after each step.

    Attributes
    ----------
    bound : float
    """

    bound: float = 2.0

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return Step(np.clip(super().step(problem, state, t, h, noise).state, -self.bound, self.bound))


class CutEuler(Cut, EulerMaruyama):
    """Euler-Maruyama with components clipped at a bound."""

    name: ClassVar[str] = "planted-em-cut"


@dataclass(frozen=True)
class CutHeun(Cut, Heun):
    """Heun's scheme with components clipped at a bound."""

    bound: float = 2.7

    name: ClassVar[str] = "planted-heun-cut"


class CutPlaten(Cut, PlatenWeak2):
    """Platen's scheme with components clipped at a bound."""

    name: ClassVar[str] = "planted-platen-cut"


class Clipped(EulerMaruyama):
    """Euler-Maruyama with states clipped at twice the start."""

    name: ClassVar[str] = "planted-em-clipped"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        bound = 2.0 * np.abs(problem.initial(1)).max()
        return Step(np.clip(super().step(problem, state, t, h, noise).state, -bound, bound))


# Schemes with memory that is not updated in a region: resetting the memory hides the error.


class Remembering(NamedTuple):
    """x, and the drift stored by the last step, both of shape (d, P)."""

    x: Array
    drift: Array


@dataclass(frozen=True)
class StaleDrift(EulerMaruyama):
    """x+ = x + h m + B(t, x) dW with m+ = f(t + h, x+), except m+ = m if |x_1+| lies between two bounds.

    Attributes
    ----------
    low, high : float
    """

    low: float = 1.3
    high: float = 10.0

    name: ClassVar[str] = "planted-em-stale"

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembering:
        """Return a state with its drift."""
        return Remembering(state, np.array(np.broadcast_to(problem.drift(t, state), state.shape)))

    def parts(self, problem: SDE, state: Remembering) -> Parts:
        """Return x without the stored drift."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Remembering, t: float, h: float, noise: Increment) -> Step:
        """Make one step; x has shape (d, P)."""
        x = state.x + h * state.drift + problem.diffused(t, state.x, noise.dW)
        stale = (self.low < np.abs(x[0])) & (np.abs(x[0]) < self.high)
        return Step(Remembering(x, np.where(stale, state.drift, problem.drift(t + h, x))))


@dataclass(frozen=True)
class Unsolved(Scheme):
    """A scheme whose algebraic component is not updated if |x_1| exceeds a bound.

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
    """The theta method whose algebraic component is not updated if |x_1| exceeds a bound."""

    name: ClassVar[str] = "planted-theta-unsolved"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)


@dataclass(frozen=True)
class UnsolvedLagged(Unsolved, LaggedAlgebraicTheta):
    """The theta method with the old y, which is not updated if |x_1| exceeds a bound."""

    name: ClassVar[str] = "planted-lagged-unsolved"


HALF_FAR_OUT = ScaledEuler("starts", 1.5, drift=0.5)
BUGS = [
    Planted("EM: drift 20 % off in a strip", ScaledEuler("x_1", 1.2, 1.5, 1.2), "gbm"),
    Planted("EM: noise 10 % off in a strip", ScaledEuler("x_1", 1.2, 1.5, 1.0, 0.9), "gbm"),
    Planted("EM: noise 10 % off beyond a well", ScaledEuler("x_1", 1.2, 10.0, 1.0, 1.1), "double-well"),
    Planted("EM: no drift near the hill", ScaledEuler("x_1", -0.03, 0.08, 0.0), "double-well"),
    Planted("Milstein: Euler far below", MilsteinBelow("x_1", high=-1.5), "hyperbolic[x_0=-1]"),
    Planted("EM: states cut at 1.5 in a double well", CutEuler(1.5), "double-well"),
    Planted("EM: states cut at 1.2 in one well", CutEuler(1.2), "ou"),
    Planted("Heun: states cut", CutHeun(), "gbm"),
    Planted("Platen: states cut at 1.5", CutPlaten(1.5), "double-well"),
    Planted("EM: half the drift far out", HALF_FAR_OUT, "linear-test"),
    Planted("EM: half the drift far out, of a pendulum", HALF_FAR_OUT, "angle-pendulum"),
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
