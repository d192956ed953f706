"""Samples that grow block by block."""

from functools import reduce
from math import isnan, sqrt

import numpy as np
import pytest

from sdaeverify.experiments.sample import Sample


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
