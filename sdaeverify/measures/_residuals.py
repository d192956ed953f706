"""What the drift measure notes on one block: the defect of each constraint at some times of every level.

The largest defects and their growth are taken at times evenly spaced in their logarithm. These leave few late times,
so that integrals over time have times of their own: one in each of 64 equal stretches.
"""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, Parts
from ..contracts.measure import Snapshot
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..forms import Problem
from ..numerics import norm
from ..numerics.statistics import group_sums
from ..simulate.tracks import HELD

TIMES = 64
NOWHERE = np.zeros((1, 1))
# Places in successive stretches are spread evenly by it, whatever period a scheme repeats itself with.
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Histogram of log2 |defect| in eighths, so that quantiles of merged blocks are known to 4.5 per cent.
BINS_PER_OCTAVE = 8
LOWEST, HIGHEST = -64, 32
EDGES = np.arange(LOWEST * BINS_PER_OCTAVE, HIGHEST * BINS_PER_OCTAVE + 1) / BINS_PER_OCTAVE


def log_spaced(steps: int) -> list[int]:
    """Return at most 64 step numbers between 1 and `steps`, evenly spaced in their logarithm."""
    return sorted({round(step) for step in np.geomspace(1, steps, min(TIMES, steps))})


def quadrature(steps: int) -> dict[int, float]:
    """Return step numbers with weights of sum 1 - 1/(2 steps): the trapezoidal rule on (0, 1] for f(0) = 0.

    Up to 64 steps all of them are taken, with half a step for the last one. Of more, 64 equal stretches have one
    each, at places that jump by the golden ratio: a defect that is reset every few steps is met at all its phases.

    Parameters
    ----------
    steps : int

    Returns
    -------
    dict of int to float
    """
    ends = np.round(np.linspace(0, steps, min(TIMES, steps) + 1)).astype(int)
    sizes, places = np.diff(ends), (GOLDEN * np.arange(1, len(ends))) % 1.0
    weights = sizes / steps
    weights[-1] -= 0.5 / steps
    chosen = ends[:-1] + 1 + np.floor(places * sizes).astype(int)
    return dict(zip(chosen.tolist(), weights.tolist(), strict=True))


class ResidualObserver:
    """Notes |g| at wanted steps: sums of squares over groups, the maximum, and each path's largest value.

    And (int_0^T |g|^2 dt)^{1/2} of each path, g being 0 at the start. A path that was held where it found no root
    says nothing of a constraint that moves away from it. It is among the failed ones, which nothing verifies.
    """

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem = problem
        self.times = [log_spaced(steps) for steps in settings.steps]
        self.noted = [frozenset(times) for times in self.times]
        self.weights = [quadrature(steps) for steps in settings.steps]
        self.wanted: Sequence[frozenset[int]] = [
            times.union(weights) for times, weights in zip(self.noted, self.weights, strict=True)
        ]
        residuals = problem.residuals(parts)
        self.names = list(residuals)
        self.paths = next(iter(residuals.values())).value.shape[-1]
        self.squares: dict[str, list[list[Array]]] = {name: [[] for _ in self.times] for name in self.names}
        self.worst = {name: np.zeros((settings.levels, self.paths)) for name in self.names}
        self.scale = {name: np.zeros(settings.levels) for name in self.names}
        self.integral = {name: np.zeros((settings.levels, self.paths)) for name in self.names}

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note the defects after one of the wanted steps."""
        for name, residual in self.problem.residuals(parts).items():
            size = np.where(parts.get(HELD, NOWHERE)[0] > 0.0, 0.0, norm(residual.value))
            self.integral[name][level] += self.problem.horizon * self.weights[level].get(step, 0.0) * size**2
            if step in self.noted[level]:
                self.squares[name][level].append(group_sums(size * size))
                self.worst[name][level] = np.fmax(self.worst[name][level], size)
                self.scale[name][level] = np.fmax(self.scale[name][level], np.fmax.reduce(residual.scale))

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note nothing: the defects are noted at each level's own times."""

    def tally(self) -> Tally:
        """Return the sums of squares by group and time, of norms in time, histograms, maxima and scales."""
        sums: dict[str, Array] = {"paths": group_sums(np.ones(self.paths))}
        maxima: dict[str, Array] = {}
        for name in self.names:
            for level, squares in enumerate(self.squares[name]):
                sums[f"squares {name} {level}"] = np.stack(squares, axis=-1)
            sums[f"l2 {name}"] = group_sums(np.sqrt(self.integral[name]))
            sums[f"histogram {name}"] = np.stack([_histogram(worst) for worst in self.worst[name]])
            maxima[f"worst {name}"] = self.worst[name].max(axis=-1)
            maxima[f"scale {name}"] = self.scale[name]
        return Tally(sums=sums, maxima=maxima)


def quantile(histogram: Array, q: float) -> float:
    """Return the q-quantile of a histogram of log2 values, as the geometric middle of its bin."""
    total = histogram.sum()
    if total == 0.0:
        return float("nan")
    index = int(np.searchsorted(np.cumsum(histogram), q * total))
    return float(2.0 ** (0.5 * (EDGES[index] + EDGES[index + 1])))


def effective_share(histogram: Array) -> float:
    """Return (sum e^2)^2 / (M sum e^4) of a histogram of log2 e: how many paths a mean square rests on."""
    squares = 2.0 ** (EDGES[:-1] + EDGES[1:])
    total = histogram.sum()
    fourth = total * (histogram @ squares**2)
    return float((histogram @ squares) ** 2 / fourth) if fourth > 0.0 else 1.0


def _histogram(values: Array) -> Array:
    with np.errstate(divide="ignore"):
        clipped = np.clip(np.log2(values[np.isfinite(values)]), EDGES[0], EDGES[-1])
    return np.histogram(clipped, EDGES)[0].astype(float)
