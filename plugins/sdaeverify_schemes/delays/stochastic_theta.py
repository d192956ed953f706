"""The stochastic theta method: implicit in the drift, explicit in the noise."""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, DelaySDAE, Increment, ParameterError, Problem, Scheme, Step, hookimpl
from sdaeverify.numerics import Dense, Root, largest, newton, update_tolerance

from .._euler_orders import ORDERS
from ._orders import DELAYED
from ._theta import delay_theta

# Sources of mean-square stability, by the trait of the problems.
STABLE = {
    "no-delay": "Higham 2000; on dx = A x dt + ..., E |(Id - theta h A) x|^2 decreases in the equation's norm",
    "dissipative": "Qu, Huang & Liu 2010, Theorem 4.2, sharpened: E |x - theta h f|^2 decreases from theta = 1/2 on",
}

# Lagged values between mesh points are interpolated, which reduces the order to 1 unless the drift is affine in them.
TRAPEZOIDAL = Claim(
    measure="weak",
    value=2.0,
    when=frozenset({"additive-noise", "no-delay"}),
    source="measured; Kloeden & Platen 1992, section 15.4",
)


@dataclass(frozen=True)
class StochasticTheta(Scheme):
    """x+ = x + h [theta f(t + h, x+) + (1 - theta) f(t, x)] + B(t, x) dW.

    x+ is the root that Newton's method reaches from the Euler-Maruyama step. A path on which the method fails keeps
    its state and is counted.

    Attributes
    ----------
    theta : float
        Parameter between 0 (Euler-Maruyama) and 1 (drift-implicit Euler).
    """

    theta: float = 0.5

    name: ClassVar[str] = "stochastic-theta"
    form: ClassVar[tuple[type[Problem], ...]] = (SDE, DelaySDAE)
    claims: ClassVar[tuple[Claim, ...]] = (*ORDERS, *DELAYED)
    source: ClassVar[str] = "Kloeden & Platen 1992, section 12.2; Higham 2000; Qu, Huang & Liu 2010, (2.10)"

    def __post_init__(self) -> None:
        if not 0.0 <= self.theta <= 1.0:
            raise ParameterError(f"theta must be between 0 and 1, got {self.theta!r}")

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders, and mean-square stability at every step size from theta = 1/2 on."""
        value = "A-stable" if self.theta >= 0.5 else "conditional"
        second = (TRAPEZOIDAL,) if self.theta == 0.5 else ()
        stable = (
            Claim(measure="stability", value=value, when=frozenset({trait}), source=source)
            for trait, source in STABLE.items()
        )
        return (*self.claims, *second, *stable)

    def stable_below(self, problem: SDE | DelaySDAE) -> float:
        """Return the sharpened bound of Theorem 4.2 on stable step sizes; NaN without its constants."""
        known = None if isinstance(problem, SDE) else problem.reduced_dissipation
        return nan if known is None else known.sharp_step(self.theta)

    def refuses(self, problem: SDE | DelaySDAE) -> str:
        """Refuse drifts that complex steps cannot differentiate, unless theta is 0."""
        if self.theta == 0.0:
            return ""
        if isinstance(problem, DelaySDAE):
            return problem.why_not_jacobian()
        return problem.why_not_derivative_of_drift()

    def step(self, problem: SDE | DelaySDAE, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x of an SDE has shape (d, P)."""
        if isinstance(problem, DelaySDAE):
            return delay_theta(problem, state, t, h, noise, self.theta)
        x = state
        f, kick = problem.drift(t, x), problem.diffused(t, x, noise.dW)
        if self.theta == 0.0:
            return Step(x + h * f + kick)
        known = x + h * (1.0 - self.theta) * f + kick
        root = implicit(problem, t + h, self.theta * h, known, x + h * f + kick)
        new = np.where(root.converged, root.x, x)
        return Step(new, failed=~root.converged, costs={"newton_iterations": root.iterations})


def implicit(problem: SDE, t: float, s: float, known: Array, guess: Array) -> Root:
    """Solve y = known + s f(t, y) from a guess, shapes (d, P).

    Parameters
    ----------
    problem : SDE
    t : float
        Time of the new state.
    s : float
        Weight theta h of the drift at the new state.
    known : ndarray, shape (d, P)
        Terms independent of y.
    guess : ndarray, shape (d, P)
        Initial guess of Newton's method.
    """
    unit = np.eye(len(known))[..., None]

    def linearised(y: Array) -> tuple[Array, Callable[[], Dense]]:
        return y - s * problem.drift(t, y) - known, lambda: Dense(unit - s * problem.derivative_of_drift(t, y))

    return newton(linearised, guess, update_tolerance(largest(guess)), solver=Dense.solve)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the trapezoidal rule."""
    return [StochasticTheta()]
