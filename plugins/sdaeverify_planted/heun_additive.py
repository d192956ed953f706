"""Heun's scheme for additive noise with wrong stages; it claims weak order 2."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.heun import HeunAdditive


@dataclass(frozen=True)
class WrongStages(HeunAdditive):
    """x+ = x + h [(1 - w) f(t + a h, x) + w f(t + b h, y)] + B dW with y = x + h f + c B dW.

    Attributes
    ----------
    w, a, b, c : float
        1/2, 0, 1 and 1 are right.
    """

    w: float = 0.5
    a: float = 0.0
    b: float = 1.0
    c: float = 1.0

    name: ClassVar[str] = "planted-heun-stages"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        kick = apply(problem.diffusion(t, state), noise.dW)
        f = problem.drift(t + self.a * h, state)
        later = problem.drift(t + self.b * h, state + h * f + self.c * kick)
        return Step(state + h * ((1.0 - self.w) * f + self.w * later) + kick)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="Heun: stage at wrong time", scheme=WrongStages(b=0.0), problem="forced-ou"),
        Planted(bug="Heun: predictor without noise", scheme=WrongStages(c=0.0), problem="double-well"),
        Planted(bug="Heun: weights .55/.45", scheme=WrongStages(w=0.45), problem="double-well"),
        Planted(
            bug="Heun: both stages at t + h/2",
            scheme=WrongStages(a=0.5, b=0.5),
            problem="forced-ou",
            equivalent="a midpoint rule in time, of order 2 like the trapezoidal one",
        ),
    ]
