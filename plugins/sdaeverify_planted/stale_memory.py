"""Schemes that carry something along and do not renew it in a region: whoever sets it right anew sees no bug."""

from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, DelaySDAE, DelayState, Increment, Parts, Problem, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays.lagged_algebraic_theta import LaggedAlgebraicTheta
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama


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


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    stale = Planted(bug="EM: remembered drift not renewed far out", scheme=StaleDrift(), problem="ou")
    return [
        stale,
        replace(stale, bug="EM: remembered drift not renewed far out in a double well", problem="double-well"),
        replace(stale, bug="EM: remembered drift not renewed in a strip", scheme=StaleDrift(0.6, 0.9), problem="gbm"),
        replace(
            stale,
            bug="EM: remembered drift not renewed in a long run",
            scheme=StaleDrift(0.9),
            problem="ou[horizon=4]",
        ),
        Planted(bug="theta: y not solved for far out", scheme=UnsolvedTheta(0.5), problem="gbm-algebraic"),
        Planted(bug="lagged theta: y not solved for far out", scheme=UnsolvedLagged(), problem="gbm-algebraic"),
    ]
