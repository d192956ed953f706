"""What the moments measure notes on one block: the largest V of each path over the coarsest grid, at every level."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, Parts
from ..contracts.measure import Snapshot
from ..contracts.settings import Settings
from ..contracts.tally import EXTREMES, Tally, largest
from ..forms import HolonomicSDAE, Problem
from ..numerics.statistics import group_sums
from ..probe.step.semi_stability import lyapunov

# Histogram of log2 V in quarters, so that shares above any bound are known of merged blocks; infinity is in the last.
EDGES = np.arange(0.0, 256.25, 0.25)


class MomentObserver:
    """Notes max_k V(X_k) of each level and, in the last row, of the truth; NaN where it lacks a component of V."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem, self.settings = problem, settings
        self.wanted: Sequence[frozenset[int]] = [frozenset()] * settings.levels
        self.names = ("r", "v") if isinstance(problem, HolonomicSDAE) else tuple(parts)
        self.worst = np.repeat(self._V(parts)[None], settings.levels + 1, axis=0)

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note nothing: moments are taken on the coarsest grid."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note the maximum so far."""
        now = [self._V(parts) for parts in (*snapshot.levels, snapshot.truth)]
        self.worst = np.maximum(self.worst, np.stack(now))

    def tally(self) -> Tally:
        """Return sums over groups of V and V^2, histograms and the largest values."""
        V = self.worst
        sums = {
            "paths": group_sums(np.ones(V.shape[1])),
            "moment": np.moveaxis(group_sums(np.stack([V, V * V])), 1, -1),
            "histogram": np.stack([_histogram(values) for values in V]),
        }
        return Tally(sums=sums, largest={"V": largest(V, EXTREMES)})

    def _V(self, parts: Parts) -> Array:
        if not all(name in parts for name in self.names):
            return np.full(next(iter(parts.values())).shape[-1], np.nan)
        return lyapunov(self.problem, {name: parts[name] for name in self.names})


def _histogram(V: Array) -> Array:
    finite = np.where(np.isnan(V), np.inf, V)
    return np.histogram(np.clip(np.log2(finite), EDGES[0], EDGES[-1]), EDGES)[0].astype(float)
