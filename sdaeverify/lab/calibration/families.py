"""Holm's procedure over a run of 60 cells, of which fifty keep their claim, five are on the boundary and five fail.

An estimate is normal with standard error SE about order - bound, its error is estimated with G - 1 degrees of
freedom. With tests at level alpha each, a run has a false refutation with probability 1 - (1 - alpha)^5: those on the
boundary are refuted by chance, those that keep their claim hardly ever. Holm's procedure rejects whatever
Bonferroni's does, the power of which follows from the noncentral t distribution.
"""

from collections.abc import Iterator

import numpy as np
import scipy

from ...arrays import Array, Mask
from ...noise.brownian import Source
from ...numerics.statistics import GROUPS, Estimate
from ...study.holm import holm
from .rates import ExpectedRate, Rate, Trials

ALPHA, SE = 0.05, 0.05
# Cells and their distance from the bound.
KEPT, BOUNDARY, FAILED = (50, 0.2), (5, 0.0), (5, -0.25)
CELLS = KEPT[0] + BOUNDARY[0] + FAILED[0]
BY_CHANCE = 1.0 - (1.0 - ALPHA) ** BOUNDARY[0]


def family_rates(seed: int, runs: int) -> Iterator[Rate]:
    """Yield the share of runs with a false verdict, without correction and with Holm's procedure, and its power."""
    distance = np.concatenate([np.full(count, value) for count, value in (KEPT, BOUNDARY, FAILED)])
    rng = Source(seed, "families", 0, runs).stream("estimates", 0)
    values = distance + SE * rng.standard_normal((runs, CELLS))
    errors = SE * np.sqrt(rng.chisquare(GROUPS - 1, values.shape) / (GROUPS - 1))
    found = [[Estimate(*pair) for pair in zip(*run, strict=True)] for run in zip(values, errors, strict=True)]
    refuted = np.array([[estimate.p_below(0.0) for estimate in run] for run in found])
    verified = np.array([[estimate.p_above(0.0) for estimate in run] for run in found])
    yield from _rates("refutation", refuted, distance < 0.0, -FAILED[1])
    yield from _rates("verification", verified, distance > 0.0, KEPT[1])


def _rates(word: str, p: Array, right: Mask, margin: float) -> Iterator[Rate]:
    rejected = np.array([_rejected(run) for run in p])
    chance = ExpectedRate(BY_CHANCE, BY_CHANCE, f"{BY_CHANCE:.3f}")
    least = float(scipy.stats.nct.sf(scipy.special.stdtrit(GROUPS - 1, 1.0 - ALPHA / CELLS), GROUPS - 1, margin / SE))
    bonferroni = ExpectedRate(least, 1.0, f"at least {least:.3f} (Bonferroni)")
    trials = Trials("families", f"runs of {CELLS} cells")
    by_chance = np.asarray((p[:, ~right] <= ALPHA).any(axis=1))
    false = np.asarray(rejected[:, ~right].any(axis=1))
    yield trials.rate(f"false {word}, uncorrected", by_chance, chance)
    yield trials.rate(f"false {word}, Holm", false, ExpectedRate.at_most(ALPHA))
    # One cell of each run: trials are to be independent.
    yield trials.rate(f"right {word} of one cell, Holm", rejected[:, right][:, 0], bonferroni)


def _rejected(p: Array) -> Mask:
    rejected = holm({(0, cell): float(value) for cell, value in enumerate(p)}, ALPHA)
    return np.array([(0, cell) in rejected for cell in range(len(p))])
