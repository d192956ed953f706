"""Schemes that are wrong within a range of states, times, numbers or sizes of steps, or positions in a batch."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Mask, Scheme, Step
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

TINY = float(np.finfo(float).tiny)
# Marks of a step from x at time t of size h.
MARKS: Mapping[str, Callable[[SDE, Array, float, float], Array | float]] = MappingProxyType({
    "x_1": lambda problem, x, t, h: x[0],
    "starts": lambda problem, x, t, h: np.abs(x).max(axis=0) / max(TINY, np.abs(problem.initial(1)).max()),
    "path": lambda problem, x, t, h: np.arange(x.shape[1]),
    "time": lambda problem, x, t, h: t,
    "part": lambda problem, x, t, h: t / problem.horizon,
    "step": lambda problem, x, t, h: round(t / h) + 1,
    "h": lambda problem, x, t, h: h,
    **{f"step of {n}": lambda problem, x, t, h, n=n: round(t / h) % n + 1 for n in (7, 16, 100)},
})  # fmt: skip


@dataclass(frozen=True)
class Within(Scheme):
    """A scheme that is replaced by another one where a mark lies in a range.

    Attributes
    ----------
    mark : str
        Key of `MARKS`: a component of a path, its largest component relative to the start, or its index in the batch;
        time, also as a part of the horizon; number of the step from 1, also modulo 7, 16 or 100; step size.
    low, high : float
        Ends of the range low <= mark < high.
    """

    mark: str = "time"
    low: float = -inf
    high: float = inf

    def within(self, problem: SDE, x: Array, t: float, h: float) -> Mask:
        """Return on which paths a step is replaced, or whether it is on all of them."""
        mark = MARKS[self.mark](problem, x, t, h)
        return np.asarray((self.low <= mark) & (mark < self.high))


@dataclass(frozen=True)
class ScaledEuler(Within, EulerMaruyama):
    """x+ = x + a h f(t, b x) + c B(t, d x) dW within the range, Euler-Maruyama elsewhere.

    Attributes
    ----------
    drift, noise_share : float
        Factors a and c.
    of_drift, of_noise : float
        Factors b and d.
    """

    drift: float = 1.0
    noise_share: float = 1.0
    of_drift: float = 1.0
    of_noise: float = 1.0

    name: ClassVar[str] = "planted-em-scaled"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        inside = self.within(problem, state, t, h)
        shares = (self.drift, self.noise_share, self.of_drift, self.of_noise)
        a, c, b, d = (np.where(inside, share, 1.0) for share in shares)
        return Step(state + a * h * problem.drift(t, b * state) + c * problem.diffused(t, d * state, noise.dW))


class EulerWithin(Within):
    """A scheme of higher order that is Euler-Maruyama within the range, with the right limit but a lower order."""

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        right = super().step(problem, state, t, h, noise).state
        return Step(np.where(self.within(problem, state, t, h), problem.euler(t, state, h, noise), right))
