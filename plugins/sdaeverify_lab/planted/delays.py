"""Methods for delay equations with a wrong lag, a wrong algebraic component or a wrong root."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, DelaySDAE, DelayState, Increment, Lag, Problem, Step, hookimpl
from sdaeverify.numerics import solve
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays._root import hold_failed
from sdaeverify_schemes.delays._theta import Begun, algebraic, begin_step, solve_coupled
from sdaeverify_schemes.delays.lagged_algebraic_theta import LaggedAlgebraicTheta
from sdaeverify_schemes.delays.stochastic_theta import TRAPEZOIDAL, StochasticTheta

# The theta method for delay equations with lagged values of another time.


def ahead(lag: Lag, x: Array) -> Lag:
    """Use the lag at the end of the step at its beginning as well."""
    return lag._replace(now=lag.ahead(x))


def behind(lag: Lag, x: Array) -> Lag:
    """Use the lag at the beginning of the step at its end as well."""
    return Lag(lag.now, lag.now, 0.0)


def present(lag: Lag, x: Array) -> Lag:
    """Use no lag."""
    return Lag(x, np.zeros_like(x), 1.0)


def known(lag: Lag, x: Array) -> Lag:
    """Omit the part of the lag that depends on the unknown x."""
    return lag._replace(weight=0.0)


def swapped(lag: Lag, x: Array) -> Lag:
    """Swap the weights of old and unknown x if both are positive."""
    if not 0.0 < lag.weight < 1.0:
        return lag
    return Lag(lag.now, lag.known * (lag.weight / (1.0 - lag.weight)), 1.0 - lag.weight)


READINGS: Mapping[str, Callable[[Lag, Array], Lag]] = MappingProxyType(
    {f.__name__: f for f in (ahead, behind, present, known, swapped)} | {"right": lambda lag, x: lag}
)


# Order of the right method if the delay is a multiple of the step size, as on the problems of this file.
ON_MESH = replace(TRAPEZOIDAL, when=frozenset({"additive-noise"}))


class DelayedTheta(StochasticTheta):
    """The theta method restricted to delay equations."""

    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims of the right method, which also has weak order 2 on these meshes for additive noise."""
        return (*super().promises, ON_MESH) if self.theta == 0.5 else super().promises

    def _solve(self, problem: DelaySDAE, state: DelayState, t: float, h: float, begin: Begun) -> Step:
        """Solve the implicit equations of a step from its explicit part."""
        root, d = solve_coupled(problem, begin, t + h, self.theta * h), problem.dimension
        return hold_failed(state, DelayState(root.x[:d], root.x[d:]), root)


@dataclass(frozen=True)
class WrongLag(DelayedTheta):
    """Wrong lagged values, with the claims of the right method.

    Attributes
    ----------
    theta : float
    reading : str
        ``ahead``, ``behind``, ``present``, ``known``, ``swapped`` or ``right``.
    """

    reading: str = "right"

    name: ClassVar[str] = "planted-delay-lag"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        lag = READINGS[self.reading](problem.lag(state.x, h, noise), state.x)
        begin = begin_step(problem, state, t, h, noise._replace(lagged=lag.now), self.theta)._replace(lag=lag)
        return self._solve(problem, state, t, h, begin)


class AnticipatingNoise(DelayedTheta):
    """The noise uses the lagged value at the end of the step, with x from the explicit step."""

    name: ClassVar[str] = "planted-delay-anticipating"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), begin = state, begin_step(problem, state, t, h, noise, self.theta)
        now, end = begin.lag.now, begin.lag.ahead(begin.guess.x)
        added = problem.diffused(t, x, end, y, noise.dW) - problem.diffused(t, x, now, y, noise.dW)
        return self._solve(problem, state, t, h, begin._replace(known=begin.known + added))


# The explicit method for delay equations with an error that starts late, without effect up to the second delay.


@dataclass(frozen=True)
class LateLag(DelayedTheta):
    """The drift loses its lagged value from some time on.

    Attributes
    ----------
    theta : float
        Parameter of the method, 0 for the explicit one.
    since : float
        Time of the loss in units of the delay.
    """

    theta: float = 0.0
    since: float = 2.0

    name: ClassVar[str] = "planted-delay-late"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        # Times are sums of step sizes, with rounding errors.
        if t < (self.since - 1e-9) * problem.delay:
            return super().step(problem, state, t, h, noise)
        (x, y), lag = state, problem.lag(state.x, h, noise)
        f, kick = problem.drift(t, x, np.zeros_like(x), y), problem.diffused(t, x, lag.now, y, noise.dW)
        root = algebraic(problem, lag, t + h, x + h * f + kick, y)
        return hold_failed(state, DelayState(x + h * f + kick, root.x), root)


# The theta method for delay equations with wrong algebraic components, and with claims of related methods.


class KeptAlgebraic(DelayedTheta):
    """y keeps its initial value."""

    name: ClassVar[str] = "planted-delay-kept-y"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=result.state._replace(y=state.y))


class OldLagAlgebraic(DelayedTheta):
    """y solves the constraint with the lagged value at the beginning of the step."""

    name: ClassVar[str] = "planted-delay-old-lag-y"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result, now = super().step(problem, state, t, h, noise), problem.lag(state.x, h, noise).now
        root = algebraic(problem, Lag(now, now, 0.0), t + h, result.state.x, result.state.y)
        return hold_failed(state, DelayState(result.state.x, root.x), root)


class OldTimeAlgebraic(DelayedTheta):
    """y solves the constraint at the beginning of the step."""

    name: ClassVar[str] = "planted-delay-old-time-y"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        root = algebraic(problem, problem.lag(state.x, h, noise), t, result.state.x, result.state.y)
        return hold_failed(state, DelayState(result.state.x, root.x), root)


@dataclass(frozen=True)
class SingleIteration(DelayedTheta):
    """The explicit step, and one iteration of Newton's method for y."""

    theta: float = 0.0

    name: ClassVar[str] = "planted-delay-one-iteration"

    def refuses(self, problem: DelaySDAE) -> str:
        """Refuse problems without y."""
        return "" if problem.constraints else "the problem has no algebraic component"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), lag, u = state, problem.lag(state.x, h, noise), problem.constraint
        assert u is not None
        x = x + h * problem.drift(t, x, lag.now, y) + problem.diffused(t, x, lag.now, y, noise.dW)
        at = t + h, x, lag.ahead(x), y
        return Step(DelayState(x, y - solve(problem.linearised_constraint(*at).y, u(*at))))


@dataclass(frozen=True)
class LaggedTrapezoidal(LaggedAlgebraicTheta):
    """The trapezoidal rule with the old y, and the claimed weak order of the coupled one."""

    theta: float = 0.5

    name: ClassVar[str] = "planted-delay-lagged-trapezoidal"
    claims: ClassVar[tuple[Claim, ...]] = (TRAPEZOIDAL,)


@dataclass(frozen=True)
class AlmostHalfDelayed(DelayedTheta):
    """Theta below 1/2, stable only for short steps, with the claimed stability of theta = 1/2."""

    theta: float = 0.45

    name: ClassVar[str] = "planted-delay-theta"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims of theta = 1/2 in addition to the orders."""
        stable = Claim(measure="stability", value="A-stable", when=frozenset({"dissipative"}), source="planted")
        return (*self.claims, stable)


BUGS = [
    Planted("delay: lag one step ahead at the begin", WrongLag(reading="ahead"), "delay-ou"),
    Planted("delay: lag of the begin in the implicit part", WrongLag(reading="behind"), "delay-ou"),
    Planted("delay: no lag", WrongLag(reading="present"), "delay-linear"),
    Planted("delay: the unknown missing in the lag", WrongLag(1.0, "known"), "delay-test[horizon=12]"),
    Planted("delay: weights swapped", WrongLag(1.0, "swapped"), "delay-test[horizon=12]"),
    Planted(
        "delay: noise with the new lag",
        AnticipatingNoise(),
        "delay-linear",
        equivalent="on steps shorter than the delay it is known at the begin, and off by an error of order 1/2",
    ),
    Planted("delay: lagged drift lost after the second delay", LateLag(), "delay-test[set=II]"),
    Planted("delay: lagged drift lost near the end", LateLag(since=3.5), "delay-test[set=II]"),
    Planted("delay: lagged drift lost after the first delay", LateLag(since=1.0), "delay-test[set=II]"),
    Planted("delay: y never updated", KeptAlgebraic(), "delay-test[horizon=3.6]"),
    Planted("delay: y with the old lag", OldLagAlgebraic(), "delay-test[horizon=3.6]"),
    Planted("delay: y with the constraint of the old time", OldTimeAlgebraic(), "delay-forced"),
    Planted("delay: noise by the constraint of the old time", OldTimeAlgebraic(), "delay-growing"),
    Planted("index 1: y with the constraint of the old time", OldTimeAlgebraic(), "growing-algebraic"),
    Planted("delay: one iteration for y", SingleIteration(), "nonlinear-constraint"),
    Planted("delay: trapezoidal rule with the old y", LaggedTrapezoidal(), "noisy-circuit"),
    Planted("delay: A-stability claimed for theta = .45", AlmostHalfDelayed(), "delay-linear[A=-10,c=0,d=1]"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
