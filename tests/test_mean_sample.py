"""Samples of means."""

from math import isnan, sqrt

import numpy as np
import pytest

from facade import MeanSample


def test_mean_and_deviation():
    """Mean and deviation are those of the values, without cancellation around a large mean."""
    values = 1e8 + np.random.default_rng(1).standard_normal(1000)

    sample = MeanSample.of(values, without_root=4)

    assert (sample.paths, sample.without_root) == (1000, 4)
    assert sample.value == pytest.approx(values.mean(), rel=1e-15)
    # Squares of deviations are taken with the rounding of the mean, EPS 1e8 = 2e-8.
    assert sample.deviation == pytest.approx(values.std(ddof=1), rel=1e-7)
    assert sample.std_error == sample.deviation / sqrt(1000)


def test_lost_paths():
    """One lost path leaves no mean, and is counted."""
    sample = MeanSample.of(np.array([1.0, np.nan]), lost=1)

    assert (sample.paths, sample.lost) == (2, 1)
    assert isnan(sample.value)
    assert isnan(sample.std_error)
    assert isnan(sample.effective)


def test_no_paths():
    """Nothing has no mean, no standard error and no effective paths."""
    for nothing in (MeanSample(), MeanSample.of(np.zeros(0))):
        assert nothing.groups == ()
        assert all(map(isnan, (nothing.value, nothing.std_error, nothing.effective)))


def test_groups():
    """Paths and sums of the groups are those of the paths i mod 20."""
    values = np.random.default_rng(2).standard_normal(107)

    counts, sums = zip(*MeanSample.of(values).groups, strict=True)

    assert counts == tuple(len(values[g::20]) for g in range(20))
    assert sums == pytest.approx([values[g::20].sum() for g in range(20)], rel=1e-13)


def test_effective_paths():
    """Equal values count as many as they are, and one that outweighs all others as 1."""
    values = np.random.default_rng(3).exponential(size=50)

    assert MeanSample.of(np.full(8, 0.3)).effective == pytest.approx(8.0, rel=1e-14)
    assert MeanSample.of(np.array([1.0, 0.0, 0.0, 0.0])).effective == pytest.approx(1.0, rel=1e-14)
    assert MeanSample.of(values).effective == pytest.approx(values.sum() ** 2 / (values**2).sum(), rel=1e-13)
