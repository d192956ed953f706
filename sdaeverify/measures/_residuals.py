"""What the drift measure notes on one block: the defect of each constraint at log-spaced times of every level."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, Parts
from ..forms import Problem
from ..lanes import Snapshot
from ..numerics import norm
from ..settings import Settings
from ..statistics import group_sums
from ..tally import Tally

TIMES = 64
# Histogram of log2 |defect| in eighths, so that quantiles of merged blocks are known to 4.5 per cent.
BINS_PER_OCTAVE = 8
LOWEST, HIGHEST = -64, 32
EDGES = np.arange(LOWEST * BINS_PER_OCTAVE, HIGHEST * BINS_PER_OCTAVE + 1) / BINS_PER_OCTAVE


def log_spaced(steps: int) -> list[int]:
    """Return at most 64 step numbers between 1 and `steps`, evenly spaced in their logarithm."""
    return sorted({round(step) for step in np.geomspace(1, steps, min(TIMES, steps))})


class ResidualObserver:
    """Notes |g| at wanted steps: sums of squares over groups, the maximum, and each path's largest value."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem = problem
        self.times = [log_spaced(steps) for steps in settings.steps]
        self.wanted: Sequence[frozenset[int]] = [frozenset(times) for times in self.times]
        residuals = problem.residuals(parts)
        self.names = list(residuals)
        self.paths = next(iter(residuals.values())).value.shape[-1]
        self.squares: dict[str, list[list[Array]]] = {name: [[] for _ in self.times] for name in self.names}
        self.worst = {name: np.zeros((settings.levels, self.paths)) for name in self.names}
        self.scale = {name: np.zeros(settings.levels) for name in self.names}

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note the defects after one of the wanted steps."""
        for name, residual in self.problem.residuals(parts).items():
            size = norm(residual.value)
            self.squares[name][level].append(group_sums(size * size))
            self.worst[name][level] = np.fmax(self.worst[name][level], size)
            self.scale[name][level] = np.fmax(self.scale[name][level], np.fmax.reduce(residual.scale))

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note nothing: the defects are noted at each level's own times."""

    def tally(self) -> Tally:
        """Return the sums of squares by group and time, histograms, maxima and scales."""
        sums: dict[str, Array] = {"paths": group_sums(np.ones(self.paths))}
        maxima: dict[str, Array] = {}
        for name in self.names:
            for level, squares in enumerate(self.squares[name]):
                sums[f"squares {name} {level}"] = np.stack(squares, axis=-1)
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
