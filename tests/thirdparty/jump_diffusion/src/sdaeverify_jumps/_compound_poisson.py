"""A compound Poisson process as a record of noise: the times and marks of the jumps of each step."""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from sdaeverify import Array

JUMPS = "jumps"
# Steps with more jumps than this are as rare as h^3: they do not show in orders up to 1.
MOST = 2


class Jumps(NamedTuple):
    """The jumps of a step in up to K slots, in the order of time.

    Attributes
    ----------
    time : ndarray, shape (..., K, P)
        As a part of the step; 1 in an empty slot.
    mark : ndarray, shape (..., K, P)
        0 in an empty slot.
    """

    time: Array
    mark: Array

    @property
    def total(self) -> Array:
        """Increment of J, shape (P,)."""
        return np.asarray(self.mark.sum(axis=-2))


@dataclass(frozen=True)
class CompoundPoisson:
    """Jumps at a constant rate, whose marks are independent and have finitely many values.

    Attributes
    ----------
    rate : float
        Jumps per unit of time.
    values, weights : tuple of float
        Marks and their probabilities.
    """

    rate: float
    values: tuple[float, ...]
    weights: tuple[float, ...]

    @property
    def name(self) -> str:
        """Name under which increments hold the jumps."""
        return JUMPS

    @property
    def mean(self) -> float:
        """Mean of a mark."""
        return float(np.dot(self.values, self.weights))

    def begin(self, rng: np.random.Generator, h: float, paths: int) -> Jumps:
        """Return the jumps of one step: given their number, times are uniform and independent."""
        counts = rng.poisson(self.rate * h, paths)
        slots = np.arange(counts.max(initial=0))[:, None] < counts
        time = np.where(slots, rng.random(slots.shape), 1.0)
        mark = np.where(slots, rng.choice(self.values, size=slots.shape, p=self.weights), 0.0)
        order = np.argsort(time, axis=0, kind="stable")
        return Jumps(*(np.take_along_axis(part, order, axis=0)[None] for part in (time, mark)))

    def refined(self, coarse: Jumps, h: float, rng: np.random.Generator) -> Jumps:
        """Put each jump into the half of the step that its time is in."""
        early = coarse.time < 0.5
        marks = np.where(early, coarse.mark, 0.0), np.where(early, 0.0, coarse.mark)
        times = np.where(early, 2.0 * coarse.time, 1.0), np.where(early, 1.0, 2.0 * coarse.time - 1.0)
        return Jumps(*(np.stack(pair, axis=1).reshape(-1, *coarse.time.shape[1:]) for pair in (times, marks)))

    def joined(self, first: Jumps, second: Jumps) -> Jumps:
        """Put the jumps of two steps into one of twice the length."""
        late = np.where(second.mark != 0.0, 0.5 + 0.5 * second.time, 1.0)
        time = np.concatenate([np.where(first.mark != 0.0, 0.5 * first.time, 1.0), late], axis=-2)
        return Jumps(time, np.concatenate([first.mark, second.mark], axis=-2))

    def rule(self, h: float) -> tuple[Jumps, Array]:
        """Return all marks of up to two jumps, and their probabilities; no jump has what is left."""
        marks, shares = [np.zeros(MOST)], [0.0]
        for count in range(1, MOST + 1):
            often = np.exp(-self.rate * h) * (self.rate * h) ** count / count
            for chosen in product(range(len(self.values)), repeat=count):
                marks.append(np.array([*(self.values[i] for i in chosen), *[0.0] * (MOST - count)]))
                shares.append(often * float(np.prod([self.weights[i] for i in chosen])))
        mark, weights = np.stack(marks, axis=-1), np.array(shares)
        weights[0] = 1.0 - weights.sum()
        time = np.where(mark != 0.0, np.arange(1.0, MOST + 1)[:, None] / (MOST + 1), 1.0)
        return Jumps(time, mark), weights
