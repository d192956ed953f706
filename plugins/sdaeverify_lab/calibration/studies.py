"""The studies of a calibration: events counted over many samples, with prescribed ranges of their rates.

Slopes
    Coverage of the jackknife's interval for the slope of pathwise errors and of mean differences, and its one-sided
    tails. The true slope comes from an independent sample: each half of the repetitions is compared with the other
    half.
Looks
    The sequential rule with the bound exactly at the true slope, where every decision is an error. Looks are at
    n = UNIT, 2 UNIT, 4 UNIT, ..., POOLED UNIT paths. With the level alpha/K at each of K looks, the probability of an
    error on one side is at most alpha; with level alpha at each look (peeking), it is not.
Published intervals and verdicts
    The strong measure as a whole, on sequences of paths, with true and false claims.
Families
    Holm's procedure over a run of 60 cells: the claim holds in fifty, is on the boundary in five and fails in five.
    An estimate is normal with standard error SE about order - bound, and its error is estimated with G - 1 degrees of
    freedom. With tests at level alpha each, a run has a false refutation with probability 1 - (1 - alpha)^5, because
    claims on the boundary are refuted by chance and those that hold hardly ever. Holm's procedure rejects all
    hypotheses that Bonferroni's does, the power of which follows from the noncentral t distribution.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np
import scipy

from sdaeverify import Array, Mask
from sdaeverify.measuring import FITTED, Estimate
from sdaeverify.numerics import GROUPS, log_norms, slope_weights
from sdaeverify.studying import DEEP_PATHS, RESOLVED, Source, holm

from .judged import ABOVE, LOOKS
from .rates import COVERED, NOTHING, ExpectedRate, Rate, Trials
from .repeated import POOLED, UNIT, estimates, opposite, pool
from .samples import Sample

COUNTS = (1, 4, POOLED)
NORMS = {"L1/2": (0, 0.5), "L1": (1, 1.0), "L2": (2, 2.0)}
# Nominal levels of one-sided tests; the true level must be at most twice as large.
LEVELS = (0.01, 0.001)
ALLOWED = 2.0
MEAN_COUNTS = (4, POOLED)
ALPHA = 0.05
RULES = {
    "level alpha/K at each look": (len(LOOKS), ExpectedRate.at_most(ALPHA)),
    "peeking at level alpha": (1, ExpectedRate(ALPHA, 1.0, f"more than {ALPHA:g}")),
}
# Coverage above nominal is allowed, because a bound on the bias is added.
PUBLISHED = ExpectedRate(COVERED.low, 1.0, f"at least {COVERED.low:g}")
TIERS = ("paths alone", "with local orders")
# Largest rate of wrong verdicts on either side, for the confidence of 99 % of a run.
WRONG = ExpectedRate.at_most(0.01)
# Standard error of an estimate in a family of tests.
SE = 0.05
# Numbers of cells and their distance from the bound.
KEPT, BOUNDARY, FAILED = (50, 0.2), (5, 0.0), (5, -0.25)
CELLS = KEPT[0] + BOUNDARY[0] + FAILED[0]
BY_CHANCE = 1.0 - (1.0 - ALPHA) ** BOUNDARY[0]


def slopes(sample: Sample, count: int, norm: str, every: int | None = None) -> tuple[Estimate, Array]:
    """Return slopes of pooled repetitions, and for each the slope of all repetitions in the other half.

    Parameters
    ----------
    sample : Sample
    count : int
        Number of pooled repetitions.
    norm : str
        Key of `NORMS`.
    every : int, optional
        Distance between the pooled groups, in repetitions.

    Returns
    -------
    Estimate
        Estimate whose fields have the shape (R,).
    ndarray, shape (R,)
    """
    index, p = NORMS[norm]
    slope = partial(_slope, slope_weights(np.log2(sample.h[-FITTED:])), p)
    tally = pool(sample.strong, count, every)
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


def mean_difference_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the coverage of 95 % intervals of the slope for each observable of the case."""
    for observable in sample.case.weak:
        for count in MEAN_COUNTS:
            yield _rate(sample, f"values {observable}", count)


def _rate(sample: Sample, name: str, count: int) -> Rate:
    slope = partial(_mean_slope, slope_weights(np.log2(sample.h[:-1][-FITTED:])))
    tally = pool(sample.weak, count)
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


def look_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the rates of false decisions on either side, with and without the correction for looks."""
    found = [slopes(sample, count, "L1", POOLED) for count in LOOKS]
    for rule, (looks, expected) in RULES.items():
        sides = []
        for estimate, truth in found:
            low, high = estimate.interval(1.0 - 2.0 * ALPHA / looks)
            sides.append(np.where(low > truth, 1, np.where(high < truth, -1, 0)))
        decided, paths = first_decision(np.array(sides))
        # Heavy-tailed samples of this size are not judged in a run, so that no range is prescribed.
        promised = NOTHING if sample.case.heavy else expected
        trials = Trials("looks", sample.case.label, float(paths.mean()))
        yield trials.rate(f"falsely verified, {rule}", decided > 0, promised)
        yield trials.rate(f"falsely refuted, {rule}", decided < 0, promised)


def first_decision(sides: Array) -> tuple[Array, Array]:
    """Return the first nonzero decision of each sequence, and the number of paths up to it.

    Parameters
    ----------
    sides : ndarray, shape (K, S)

    Returns
    -------
    ndarray, shape (S,)
    ndarray, shape (S,)
    """
    # The last look ends the sequence in any case.
    ends = np.concatenate([sides[:-1] != 0, np.ones_like(sides[-1:], dtype=bool)]).argmax(axis=0)
    return sides[ends, np.arange(sides.shape[1])], UNIT * np.array(LOOKS)[ends]


def published_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the coverage of the published intervals of the slope and of the asymptotic order."""
    judged = sample.judged
    assert judged is not None
    trials = Trials("published", sample.case.label, UNIT * POOLED)
    _, truth = slopes(sample, POOLED, "L1")
    slope = (judged.low <= truth) & (truth <= judged.high)
    yield trials.rate("interval of the slope, 95 %", slope, PUBLISHED)
    order = abs(judged.asymptotic - sample.case.order) <= judged.half
    yield trials.rate("interval of the asymptotic order, 95 %", order, PUBLISHED)


def verdict_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the rates of verdicts on the true order and on half an order more."""
    judged = sample.judged
    assert judged is not None
    for tier, words in enumerate(TIERS):
        for claim, above in enumerate(ABOVE):
            outcome, paths = judged.outcome[:, claim, tier], judged.paths[:, claim, tier]
            trials = Trials("verdicts", sample.case.label, float(paths.mean()))
            claimed = f"order + {above:g}" if above else "true order"
            yield trials.rate(f"{claimed} verified, {words}", outcome > 0, WRONG if above else NOTHING)
            yield trials.rate(f"{claimed} refuted, {words}", outcome < 0, NOTHING if above else WRONG)


def family_rates(seed: int, runs: int) -> Iterator[Rate]:
    """Yield the rate of runs with a false verdict, without correction and with Holm's procedure, and its power."""
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
    rejected = np.array([_reject(run) for run in p])
    chance = ExpectedRate(BY_CHANCE, BY_CHANCE, f"{BY_CHANCE:.3f}")
    least = float(scipy.stats.nct.sf(scipy.special.stdtrit(GROUPS - 1, 1.0 - ALPHA / CELLS), GROUPS - 1, margin / SE))
    bonferroni = ExpectedRate(least, 1.0, f"at least {least:.3f} (Bonferroni)")
    trials = Trials("families", f"runs of {CELLS} cells")
    by_chance = np.asarray((p[:, ~right] <= ALPHA).any(axis=1))
    false = np.asarray(rejected[:, ~right].any(axis=1))
    yield trials.rate(f"false {word}, uncorrected", by_chance, chance)
    yield trials.rate(f"false {word}, Holm", false, ExpectedRate.at_most(ALPHA))
    # One cell of each run, because trials must be independent.
    yield trials.rate(f"right {word} of one cell, Holm", rejected[:, right][:, 0], bonferroni)


def _reject(p: Array) -> Mask:
    rejected = holm({(0, cell): float(value) for cell, value in enumerate(p)}, ALPHA)
    return np.array([(0, cell) in rejected for cell in range(len(p))])
