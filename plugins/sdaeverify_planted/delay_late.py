"""The explicit method of delay equations that goes wrong late: nothing of it shows up to the second delay."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import DelaySDAE, DelayState, Increment, Problem, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays._root import hold_failed
from sdaeverify_schemes.delays._theta import algebraic
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta


@dataclass(frozen=True)
class LateLag(StochasticTheta):
    """The lagged value is missing in the drift from some time on.

    Attributes
    ----------
    theta : float
        0 is meant.
    since : float
        When, in delays.
    """

    theta: float = 0.0
    since: float = 2.0

    name: ClassVar[str] = "planted-delay-late"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        # Times are sums of step sizes, and rounded.
        if t < (self.since - 1e-9) * problem.delay:
            return super().step(problem, state, t, h, noise)
        (x, y), lag = state, problem.lag(state.x, h, noise)
        f, kick = problem.drift(t, x, np.zeros_like(x), y), problem.diffused(t, x, lag.now, y, noise.dW)
        root = algebraic(problem, lag, t + h, x + h * f + kick, y)
        return hold_failed(state, DelayState(x + h * f + kick, root.x), root)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    late = Planted(
        bug="delay: lagged drift lost after the second delay", scheme=LateLag(), problem="delay-test[set=II]"
    )
    return [
        late,
        replace(late, bug="delay: lagged drift lost near the end", scheme=LateLag(since=3.5)),
        replace(late, bug="delay: lagged drift lost after the first delay", scheme=LateLag(since=1.0)),
    ]
