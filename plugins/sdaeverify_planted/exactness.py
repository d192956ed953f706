"""Euler-Maruyama that is inexact where every scheme is exact; in the orders it may stay hidden."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama


class TwiceAStep(EulerMaruyama):
    """Two steps of size h where one is asked for."""

    name: ClassVar[str] = "planted-em-double-step"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make two steps."""
        once = super().step(problem, state, t, h, noise).state
        return super().step(problem, once, t + h, h, noise)


class LateStart(EulerMaruyama):
    """The first step, from t = 0, is left out: an error of the order that is claimed."""

    name: ClassVar[str] = "planted-em-late-start"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step, except for the first."""
        return super().step(problem, state, t, h, noise) if t > 0.0 else Step(state)


class SinglePrecision(EulerMaruyama):
    """Rounds every state to single precision."""

    name: ClassVar[str] = "planted-em-single-precision"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = super().step(problem, state, t, h, noise).state
        return Step(new.astype(np.float32).astype(float))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, EulerMaruyama] = {
        "two steps in place of one": TwiceAStep(),
        "first step left out": LateStart(),
        "states rounded to single precision": SinglePrecision(),
    }
    return [Planted(bug=f"EM: {bug}", scheme=scheme, problem="gbm") for bug, scheme in bugs.items()]
