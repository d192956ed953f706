"""Platen's scheme with wrong variables or wrong supporting values; it claims weak order 2."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, TWO_POINT, Array, Increment, Law, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2

# P(|N| <= QUANTILE) = 3/4 for a standard normal N.
QUANTILE = 1.1503493803760079


def heavy(x: Array) -> Array:
    """Return 2 sign(x) where |x| is beyond its quartiles, 0 elsewhere: variance 1 and fourth moment 4."""
    return 2.0 * np.sign(x) * (np.abs(x) > QUANTILE)


class HeavyLaw(PlatenWeak2):
    """A three-point law of variance 1 whose fourth moment is 4 in place of 3."""

    name: ClassVar[str] = "planted-platen-fourth-moment"
    law: ClassVar[Law] = Law("three-point of fourth moment 4", heavy, (-2.0, 0.0, 2.0), (1 / 8, 3 / 4, 1 / 8))


class TwoPointLaw(PlatenWeak2):
    """Variables +-sqrt(h), whose fourth moment is h^2."""

    name: ClassVar[str] = "planted-platen-two-point"
    law: ClassVar[Law] = TWO_POINT


@dataclass(frozen=True)
class WrongSupport(PlatenWeak2):
    """Supporting values y_+- = x + a h f +- s sqrt(h) B and y = x + a h f + B dW, for one Brownian motion.

    Attributes
    ----------
    s, a : float
        1 is right for both.
    """

    s: float = 1.0
    a: float = 1.0

    name: ClassVar[str] = "planted-platen-support"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, dW = state, noise.dW
        f, B = problem.drift(t, x), problem.diffusion(t, x)
        centre, spread = x + self.a * h * f, self.s * np.sqrt(h) * B[:, 0]
        up, down = problem.diffusion(t + h, centre + spread), problem.diffusion(t + h, centre - spread)
        drift = 0.5 * h * (f + problem.drift(t + h, centre + apply(B, dW)))
        kick = 0.25 * (apply(up + down + 2.0 * B, dW) + apply(up - down, dW * dW - h) / np.sqrt(h))
        return Step(x + drift + kick)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, PlatenWeak2] = {
        "support +5 %": WrongSupport(s=1.05),
        "wrong 4th moment": HeavyLaw(),
        "two-point variables": TwoPointLaw(),
        "predictor without drift": WrongSupport(a=0.0),
    }
    return [Planted(bug=f"Platen: {bug}", scheme=scheme, problem="gbm") for bug, scheme in bugs.items()]
