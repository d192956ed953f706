"""Weak errors along paths: slopes of log2 |mean difference| between successive step sizes."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...arrays import Array
from ...measures.judge import FITTED, RESOLVED
from ...numerics.statistics import slope_weights
from .many import estimates, opposite
from .rates import NOTHING, Rate, Trials
from .repeated import POOLED, UNIT, pooled
from .samples import Sample
from .slopes import COVERED

COUNTS = (4, POOLED)


def mean_difference_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the coverage of 95 % intervals of the slope, for each observable of the case."""
    for observable in sample.case.weak:
        for count in COUNTS:
            yield _rate(sample, f"values {observable}", count)


def _rate(sample: Sample, name: str, count: int) -> Rate:
    slope = partial(_slope, slope_weights(np.log2(sample.h[:-1][-FITTED:])))
    tally = pooled(sample.weak, count)
    values, counts = tally.sums[name], tally.sums["paths"][0]
    low, high = estimates(values, counts, slope).interval(0.95)
    everything = sample.weak.sums[name].sum(axis=1) / UNIT
    truth = opposite(everything, slope, sample.sequences, len(values))
    finest = estimates(values, counts, lambda means: means[-2] - means[-1])
    signal = float(np.median(abs(finest.value) / finest.se))
    resolved = signal >= RESOLVED
    trials = Trials("mean differences", f"{sample.case.label}, {name.removeprefix('values ')}", UNIT * count)
    statistic = "interval of the weak slope, 95 %" + ("" if resolved else ", unresolved")
    return trials.rate(statistic, (low <= truth) & (truth <= high), COVERED if resolved else NOTHING)


def _slope(weights: Array, means: Array) -> Array:
    differences = (means[:-1] - means[1:])[-FITTED:]
    return np.asarray(np.einsum("l,l...->...", weights, np.log2(abs(differences))))
