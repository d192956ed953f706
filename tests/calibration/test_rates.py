"""Rates with their intervals, and whether they agree with what is promised."""

import numpy as np
import pytest
from scipy.stats import binom

from sdaeverify.calibration.rates import NOTHING, Expectation, Rate, Trials, clopper_pearson, offending

NOMINAL = Expectation(0.93, 0.97, "0.95 within 0.02")


def rate(hits: int, trials: int, expected: Expectation = NOMINAL) -> Rate:
    """Return a row without names."""
    return Rate("", "", "", float("nan"), hits, trials, expected)


@pytest.mark.parametrize(
    ("hits", "trials", "low", "high"),
    [(0, 10, 0.0, 1.0 - 0.025**0.1), (10, 10, 0.025**0.1, 1.0), (5, 10, 0.1871, 0.8129), (1, 20, 0.0013, 0.2487)],
)
def test_interval_is_the_tabulated_one(hits, trials, low, high):
    """Clopper and Pearson's intervals are those of the closed form at the ends, and of tables in between."""
    assert clopper_pearson(hits, trials, 0.95) == pytest.approx((low, high), abs=6e-5)


@pytest.mark.parametrize("p", [0.01, 0.05, 0.3, 0.95])
def test_interval_covers_at_least_at_its_level(p):
    """Summed over all outcomes, the probability to cover the true rate is no smaller than nominal."""
    ends = np.array([clopper_pearson(hits, 40, 0.9) for hits in range(41)])
    covering = (ends[:, 0] <= p) & (p <= ends[:, 1])

    assert binom.pmf(np.arange(41), 40, p)[covering].sum() >= 0.9


def test_agreement_is_one_of_intervals():
    """A rate agrees if its interval meets the promised range, from whichever side."""
    assert rate(670, 1000).agrees(0.01) is False
    assert rate(1000, 1000).agrees(0.01) is False
    assert rate(925, 1000).agrees(0.01) is True
    assert rate(4, 1000, Expectation.at_most(0.001)).agrees(0.01) is True
    assert rate(12, 1000, Expectation.at_most(0.001)).agrees(0.01) is False


def test_level_is_shared_among_the_rows_with_a_promise():
    """What is an outlier by itself is none among many rows, and rows without a promise take no part of the level."""
    odd, good, shown = rate(904, 1000), rate(950, 1000), rate(0, 1000, NOTHING)

    assert offending([odd]) == [odd]
    assert offending([odd, *[shown] * 500]) == [odd]
    assert offending([odd, *[good] * 500]) == []


def test_trials_are_counted():
    """A row counts the hits among its trials."""
    found = Trials("study", "case", 100.0).rate("statistic", np.array([True, False, True, True]), NOMINAL)

    assert found == Rate("study", "case", "statistic", 100.0, 3, 4, NOMINAL)
    assert found.rate == 0.75
