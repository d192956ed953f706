"""The stochastic theta method for delay equations that solves for x with the old y, unlike (2.10)."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, DelaySDAE, DelayState, Increment, ParameterError, Scheme, Step, hookimpl
from sdaeverify.numerics import Root

from .._euler_orders import STRONG_HALF
from .._small_steps import STABLE
from ._orders import DELAYED
from ._root import hold_failed, regular
from ._theta import algebraic, begin_step, run_newton

SMALL_STEPS = replace(
    STABLE,
    when=frozenset({"no-delay"}),
    source="second moments of a positive strong order: spectral radius below 1 for small h, growth rate a < 0",
)


@dataclass(frozen=True)
class LaggedAlgebraicTheta(Scheme):
    """x+ = x + h [theta f(t + h, x+, v+, y) + (1 - theta) f(t, x, v, y)] + g dW with the old y, then u(..., y+) = 0.

    The scheme avoids the coupled system of `stochastic-theta`, has the same orders and another region of mean-square
    stability. A path on which Newton's method fails keeps its state and is counted.

    Attributes
    ----------
    theta : float
        Parameter between 0 (the explicit method of `stochastic-theta`) and 1.
    """

    theta: float = 1.0

    name: ClassVar[str] = "lagged-algebraic-theta"
    form: ClassVar[type[DelaySDAE]] = DelaySDAE
    claims: ClassVar[tuple[Claim, ...]] = (*STRONG_HALF, *DELAYED, SMALL_STEPS)
    source: ClassVar[str] = "Qu, Huang & Liu 2010, (2.10) with y_n in the place of y_{n+1} in f"

    def __post_init__(self) -> None:
        if not 0.0 <= self.theta <= 1.0:
            raise ParameterError(f"theta must be between 0 and 1, got {self.theta!r}")

    def refuses(self, problem: DelaySDAE) -> str:
        """Refuse problems without y, for which `stochastic-theta` is equivalent, and drifts without derivatives."""
        if not problem.constraints:
            return "the problem has no algebraic component: use stochastic-theta"
        return "" if self.theta == 0.0 else problem.why_not_jacobian()

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        begin, s, y = begin_step(problem, state, t, h, noise, self.theta), self.theta * h, state.y
        lag, unit = begin.lag, np.eye(problem.dimension)[..., None]

        def matrix(x: Array) -> Array:
            df = problem.linearised_drift(t + h, x, lag.ahead(x), y)
            return np.asarray(unit - s * lag.total(df))

        def linearised(x: Array) -> tuple[Array, Callable[[], Array]]:
            return x - begin.known - s * problem.drift(t + h, x, lag.ahead(x), y), lambda: matrix(x)

        first = run_newton(linearised, begin.guess.x, begin.known, lag.known)
        second = algebraic(problem, lag, t + h, first.x, y)
        new = DelayState(first.x, second.x)
        sound = first.converged & second.converged & regular(problem, lag, (t, t + h), state, new)
        return hold_failed(state, new, Root(first.x, sound, first.iterations + second.iterations))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with theta = 1."""
    return [LaggedAlgebraicTheta()]
