"""The theta method of delay equations with wrong algebraic components, and with claims that its relatives keep."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import Claim, DelaySDAE, DelayState, Increment, Lag, Problem, Step, hookimpl
from sdaeverify.numerics import solve
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays._root import hold_failed
from sdaeverify_schemes.delays._theta import algebraic
from sdaeverify_schemes.delays.lagged_algebraic_theta import LaggedAlgebraicTheta
from sdaeverify_schemes.delays.stochastic_theta import TRAPEZOIDAL, StochasticTheta


class KeptAlgebraic(StochasticTheta):
    """y stays what it was at the start."""

    name: ClassVar[str] = "planted-delay-kept-y"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=result.state._replace(y=state.y))


class OldLagAlgebraic(StochasticTheta):
    """y solves the constraint with the lagged value of the step's begin."""

    name: ClassVar[str] = "planted-delay-old-lag-y"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result, now = super().step(problem, state, t, h, noise), problem.lag(state.x, h, noise).now
        root = algebraic(problem, Lag(now, now, 0.0), t + h, result.state.x, result.state.y)
        return hold_failed(state, DelayState(result.state.x, root.x), root)


class OldTimeAlgebraic(StochasticTheta):
    """y solves the constraint of the step's begin."""

    name: ClassVar[str] = "planted-delay-old-time-y"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        root = algebraic(problem, problem.lag(state.x, h, noise), t, result.state.x, result.state.y)
        return hold_failed(state, DelayState(result.state.x, root.x), root)


@dataclass(frozen=True)
class SingleIteration(StochasticTheta):
    """The explicit step, and one iteration of Newton's method for y."""

    theta: float = 0.0

    name: ClassVar[str] = "planted-delay-one-iteration"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

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
    """The trapezoidal rule with the old y, and the weak order of the coupled one."""

    theta: float = 0.5

    name: ClassVar[str] = "planted-delay-lagged-trapezoidal"
    claims: ClassVar[tuple[Claim, ...]] = (TRAPEZOIDAL,)


@dataclass(frozen=True)
class AlmostHalfDelayed(StochasticTheta):
    """Theta below 1/2 with the stability of 1/2, where it is stable for short steps only."""

    theta: float = 0.45

    name: ClassVar[str] = "planted-delay-theta"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """What theta = 1/2 keeps beside the orders."""
        stable = Claim(measure="stability", value="A-stable", when=frozenset({"dissipative"}), source="planted")
        return (*self.claims, stable)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    # No multiple of its step is the delay.
    beside = "delay-test[horizon=3.6]"
    return [
        Planted(bug="delay: y never updated", scheme=KeptAlgebraic(), problem=beside),
        Planted(bug="delay: y with the old lag", scheme=OldLagAlgebraic(), problem=beside),
        Planted(
            bug="delay: y with the constraint of the old time", scheme=OldTimeAlgebraic(), problem="delay-forced"
        ),
        Planted(bug="delay: one iteration for y", scheme=SingleIteration(), problem="nonlinear-constraint"),
        Planted(bug="delay: trapezoidal rule with the old y", scheme=LaggedTrapezoidal(), problem="noisy-circuit"),
        Planted(
            bug="delay: A-stability claimed for theta = .45",
            scheme=AlmostHalfDelayed(),
            problem="delay-linear[A=-10,c=0,d=1]",
        ),
    ]
