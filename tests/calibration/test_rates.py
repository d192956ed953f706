"""Rates with their intervals, and whether they agree with what is promised."""

import numpy as np

from facade import NOTHING, ExpectedRate, Rate, Trials, offending

NOMINAL = ExpectedRate(0.93, 0.97, "0.95 within 0.02")


def rate(hits: int, trials: int, expected: ExpectedRate = NOMINAL) -> Rate:
    """Return a row without names."""
    return Rate("", "", "", float("nan"), hits, trials, expected)


def test_agreement_is_one_of_intervals():
    """A rate agrees if its interval meets the promised range, from whichever side."""
    assert rate(670, 1000).agrees(0.01) is False
    assert rate(1000, 1000).agrees(0.01) is False
    assert rate(925, 1000).agrees(0.01) is True
    assert rate(4, 1000, ExpectedRate.at_most(0.001)).agrees(0.01) is True
    assert rate(12, 1000, ExpectedRate.at_most(0.001)).agrees(0.01) is False


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
