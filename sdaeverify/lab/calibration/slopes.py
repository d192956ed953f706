"""Slopes of pathwise errors: how often the jackknife's interval contains the true slope, and its tails.

The true slope is the one of an independent sample: each half of the repetitions is judged against the other.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...arrays import Array
from ...measures.judge import DEEP_PATHS, FITTED, RESOLVED
from ...numerics.statistics import Estimate, log_norms, slope_weights
from .many import estimates, opposite
from .rates import NOTHING, ExpectedRate, Rate, Trials
from .repeated import POOLED, UNIT, pooled
from .samples import Sample

COVERED = ExpectedRate(0.93, 0.97, "0.95 within 0.02")
COUNTS = (1, 4, POOLED)
NORMS = {"L1/2": (0, 0.5), "L1": (1, 1.0), "L2": (2, 2.0)}
# Of tests at one side; the true level is promised to be at most twice as large.
LEVELS = (0.01, 0.001)
ALLOWED = 2.0


def slopes(sample: Sample, count: int, norm: str, every: int | None = None) -> tuple[Estimate, Array]:
    """Return slopes of pooled repetitions, and for each the slope of all repetitions in the other half.

    Parameters
    ----------
    sample : Sample
    count : int
        Repetitions that are pooled.
    norm : str
        One of `NORMS`.
    every : int, optional
        Of so many neighbouring repetitions the first `count` are pooled.

    Returns
    -------
    Estimate
        Of arrays of shape (R,).
    ndarray, shape (R,)
    """
    index, p = NORMS[norm]
    slope = partial(_slope, slope_weights(np.log2(sample.h[-FITTED:])), p)
    tally = pooled(sample.strong, count, every)
    errors = sample._replace(strong=tally).errors[:, :, -FITTED:, index]
    everything = sample.errors[:, :, -FITTED:, index].sum(axis=1) / UNIT
    truth = opposite(everything, slope, sample.sequences, len(errors))
    return estimates(errors, tally.sums["paths"][0], slope), truth


def slope_rates(sample: Sample) -> Iterator[Rate]:
    """Yield coverage by norm and sample size, and one-sided tails of the L1 slope."""
    for count in COUNTS:
        promised = not sample.case.heavy or UNIT * count >= DEEP_PATHS
        trials = Trials("slope", sample.case.label, UNIT * count)
        for norm in NORMS:
            found, truth = slopes(sample, count, norm)
            low, high = found.interval(0.95)
            expected = COVERED if promised and norm != "L2" else NOTHING
            yield trials.rate(f"{norm} interval, 95 %", (low <= truth) & (truth <= high), expected)
        found, truth = slopes(sample, count, "L1")
        for level in LEVELS:
            low, high = found.interval(1.0 - 2.0 * level)
            expected = ExpectedRate.at_most(ALLOWED * level) if promised else NOTHING
            yield trials.rate(f"L1 slope taken for too low at {level:g}", high < truth, expected)
            yield trials.rate(f"L1 slope taken for too high at {level:g}", low > truth, expected)


def _slope(weights: Array, p: float, means: Array) -> Array:
    return np.asarray(np.einsum("l,l...->...", weights, log_norms(means, p)))


# Weak errors along paths: slopes of log2 |mean difference| between successive step sizes.


MEAN_COUNTS = (4, POOLED)


def mean_difference_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the coverage of 95 % intervals of the slope, for each observable of the case."""
    for observable in sample.case.weak:
        for count in MEAN_COUNTS:
            yield _rate(sample, f"values {observable}", count)


def _rate(sample: Sample, name: str, count: int) -> Rate:
    slope = partial(_mean_slope, slope_weights(np.log2(sample.h[:-1][-FITTED:])))
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


def _mean_slope(weights: Array, means: Array) -> Array:
    differences = (means[:-1] - means[1:])[-FITTED:]
    return np.asarray(np.einsum("l,l...->...", weights, np.log2(abs(differences))))
