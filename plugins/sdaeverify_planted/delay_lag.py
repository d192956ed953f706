"""The theta method of delay equations with lagged values that are those of another time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from sdaeverify import Array, DelaySDAE, DelayState, Increment, Lag, Problem, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays._root import hold_failed
from sdaeverify_schemes.delays._theta import begin_step, solve_coupled
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta


def ahead(lag: Lag, x: Array) -> Lag:
    """Return the lag of the step's end at its begin as well."""
    return lag._replace(now=lag.ahead(x))


def behind(lag: Lag, x: Array) -> Lag:
    """Return the lag of the step's begin at its end as well."""
    return Lag(lag.now, lag.now, 0.0)


def present(lag: Lag, x: Array) -> Lag:
    """Return no lag at all."""
    return Lag(x, np.zeros_like(x), 1.0)


def known(lag: Lag, x: Array) -> Lag:
    """Return it without the share of the unknown x."""
    return lag._replace(weight=0.0)


def swapped(lag: Lag, x: Array) -> Lag:
    """Return it with the weights of old and unknown x swapped, where both are positive."""
    if not 0.0 < lag.weight < 1.0:
        return lag
    return Lag(lag.now, lag.known * (lag.weight / (1.0 - lag.weight)), 1.0 - lag.weight)


READINGS: Mapping[str, Callable[[Lag, Array], Lag]] = MappingProxyType(
    {f.__name__: f for f in (ahead, behind, present, known, swapped)} | {"right": lambda lag, x: lag}
)


@dataclass(frozen=True)
class WrongLag(StochasticTheta):
    """The lagged values are read wrong; the claims are those of the right method.

    Attributes
    ----------
    theta : float
    reading : str
        ``ahead``, ``behind``, ``present``, ``known``, ``swapped`` or ``right``.
    """

    reading: str = "right"

    name: ClassVar[str] = "planted-delay-lag"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        lag = READINGS[self.reading](problem.lag(state.x, h, noise), state.x)
        begin = begin_step(problem, state, t, h, noise._replace(lagged=lag.now), self.theta)._replace(lag=lag)
        root = solve_coupled(problem, begin, t + h, self.theta * h)
        return hold_failed(state, DelayState(root.x[: problem.dimension], root.x[problem.dimension :]), root)


class AnticipatingNoise(StochasticTheta):
    """The noise reads the lagged value of the step's end, x there being that of the explicit step."""

    name: ClassVar[str] = "planted-delay-anticipating"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), begin = state, begin_step(problem, state, t, h, noise, self.theta)
        now, end = begin.lag.now, begin.lag.ahead(begin.guess.x)
        added = problem.diffused(t, x, end, y, noise.dW) - problem.diffused(t, x, now, y, noise.dW)
        root = solve_coupled(problem, begin._replace(known=begin.known + added), t + h, self.theta * h)
        return hold_failed(state, DelayState(root.x[: problem.dimension], root.x[problem.dimension :]), root)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    # Its coarsest steps are longer than the delay.
    long = "delay-test[horizon=12]"
    begin = Planted(
        bug="delay: lag one step ahead at the begin", scheme=WrongLag(reading="ahead"), problem="delay-ou"
    )
    return [
        begin,
        replace(begin, bug="delay: lag of the begin in the implicit part", scheme=WrongLag(reading="behind")),
        Planted(bug="delay: no lag", scheme=WrongLag(reading="present"), problem="delay-linear"),
        Planted(bug="delay: the unknown missing in the lag", scheme=WrongLag(1.0, "known"), problem=long),
        Planted(bug="delay: weights swapped", scheme=WrongLag(1.0, "swapped"), problem=long),
        Planted(
            bug="delay: noise with the new lag",
            scheme=AnticipatingNoise(),
            problem="delay-linear",
            equivalent="on steps shorter than the delay it is known at the begin, and off by an error of order 1/2",
        ),
    ]
