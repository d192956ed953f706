"""Euler-Maruyama with coefficients taken at wrong places: exact where they are constant, consistent nowhere else."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama


@dataclass(frozen=True)
class WrongPlaces(EulerMaruyama):
    """x+ = x + h f(c t + d h, a x) + B(t, b x) dW.

    Attributes
    ----------
    a, b, c, d : float
        1, 1, 1 and 0 are right.
    """

    a: float = 1.0
    b: float = 1.0
    c: float = 1.0
    d: float = 0.0

    name: ClassVar[str] = "planted-em-places"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f = problem.drift(self.c * t + self.d * h, self.a * state)
        return Step(state + h * f + apply(problem.diffusion(t, self.b * state), noise.dW))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs and the equivalent change."""
    return [
        Planted(bug="EM: drift at 0.98 x", scheme=WrongPlaces(a=0.98), problem="gbm"),
        Planted(bug="EM: diffusion at 1.005 x", scheme=WrongPlaces(b=1.005), problem="gbm"),
        Planted(bug="EM: drift always at time 0", scheme=WrongPlaces(c=0.0), problem="forced-ou"),
        Planted(
            bug="EM: drift at the end of the step",
            scheme=WrongPlaces(d=1.0),
            problem="forced-ou",
            equivalent="a change of size h^2 of the step, which Euler-Maruyama has an error of anyway",
        ),
    ]
