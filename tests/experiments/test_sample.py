"""Samples that grow block by block."""

from functools import reduce
from math import isnan, sqrt

import numpy as np
import pytest

from sdaeverify.lab.experiments.sample import Sample


def test_merged_blocks():
    """Blocks of any size merge to mean and deviation of all values, without cancellation around a large mean."""
    values = 1e8 + np.random.default_rng(1).standard_normal(1000)
    blocks = [Sample.of(part, without_root=1) for part in np.split(values, [1, 17, 500])]

    merged = reduce(Sample.merged, blocks, Sample())

    assert merged.paths == 1000
    assert merged.without_root == 4
    assert merged.value == pytest.approx(values.mean(), rel=1e-15)
    # Squares of deviations are taken with the rounding of the means, EPS 1e8 = 2e-8.
    assert merged.deviation == pytest.approx(values.std(ddof=1), rel=1e-7)
    assert merged.std_error == merged.deviation / sqrt(1000)


def test_lost_paths():
    """One lost path leaves no mean, and is counted."""
    merged = Sample.of(np.ones(3)).merged(Sample.of(np.array([1.0, np.nan]), lost=1))

    assert (merged.paths, merged.lost) == (5, 1)
    assert isnan(merged.value)
    assert isnan(merged.std_error)


def test_errors_stay():
    """What went wrong in one block is said of the whole sample."""
    right, wrong = Sample.of(np.ones(3)), Sample(error="no view")

    for merged in (right.merged(wrong), wrong.merged(right), right.merged(wrong).merged(right)):
        assert merged.error == "no view"
        assert isnan(merged.value)


def test_no_paths():
    """Nothing has no mean and no standard error, and changes nothing."""
    assert isnan(Sample().value)
    assert isnan(Sample().std_error)
    assert Sample().merged(Sample()) == Sample()
    assert Sample.of(np.ones(3)).merged(Sample()) == Sample.of(np.ones(3))


def test_groups():
    """Paths and sums of the groups are those of all paths, however they are cut into blocks of whole rounds."""
    values = np.random.default_rng(2).standard_normal(107)

    merged = Sample.of(values[:40]).merged(Sample.of(values[40:]))

    counts, sums = zip(*merged.groups, strict=True)
    assert counts == tuple(len(values[g::20]) for g in range(20))
    assert sums == pytest.approx([values[g::20].sum() for g in range(20)], rel=1e-13)
    assert Sample().groups == ()


def test_effective_paths():
    """Equal values count as many as they are, and one that outweighs all others as 1."""
    equal = Sample.of(np.full(8, 0.3))
    one = Sample.of(np.array([1.0, 0.0, 0.0, 0.0])).merged(Sample.of(np.zeros(4)))
    values = np.random.default_rng(3).exponential(size=50)

    assert equal.effective == pytest.approx(8.0, rel=1e-14)
    assert one.effective == pytest.approx(1.0, rel=1e-14)
    assert Sample.of(values).effective == pytest.approx(values.sum() ** 2 / (values**2).sum(), rel=1e-13)
    assert isnan(Sample().effective)
    assert isnan(Sample.of(np.array([1.0, np.nan]), lost=1).effective)
