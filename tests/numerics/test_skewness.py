"""p-values of means of skewed variables are those of the normal law after a correction."""

import numpy as np
import pytest
import scipy

from facade import correct_for_skewness
from sdaeverify.numerics.statistics import GROUPS

PATHS, BATCHES, BATCH = 1020, 20, 2000
# Skewed variables of mean 1, made of normal ones.
SKEWED = {
    "square": lambda x: x**2,
    "log-normal, 1/2": lambda x: np.exp(0.5 * x - 0.125),
    "log-normal, 1": lambda x: np.exp(x - 0.5),
}


def p_values(shape, mean=1.0):
    """Return p-values that the mean is no less than a number, as they are and corrected, of many samples."""
    rng, found = np.random.Generator(np.random.Philox(key=7)), []
    for _ in range(BATCHES):
        x = shape(rng.standard_normal((BATCH, GROUPS, PATHS // GROUPS)))
        groups, centred = x.mean(axis=2), x - x.mean(axis=(1, 2), keepdims=True)
        se = groups.std(axis=1, ddof=1) / np.sqrt(GROUPS)
        plain = scipy.special.stdtr(GROUPS - 1, (groups.mean(axis=1) - mean) / se)
        skewness = (centred**3).mean(axis=(1, 2)) / (centred**2).mean(axis=(1, 2)) ** 1.5
        corrected = [
            correct_for_skewness(p, g, PATHS) for p, g in zip(plain.tolist(), skewness.tolist(), strict=True)
        ]
        found.append((plain, corrected))
    return np.concatenate(found, axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", SKEWED)
@pytest.mark.parametrize("level", [1e-3, 2e-4])
def test_a_right_mean_is_refuted_no_more_often_than_the_level_says(name, level):
    """Of 40000 samples no more are refuted than one in 10^4 such tests allows, and fewer than uncorrected."""
    plain, corrected = (np.count_nonzero(p <= level) for p in p_values(SKEWED[name]))
    allowed = scipy.stats.binom.isf(1e-4, BATCHES * BATCH, level)

    assert corrected <= allowed
    assert plain > corrected
    if name != "log-normal, 1/2":
        assert plain > level * BATCHES * BATCH


def test_a_wrong_mean_is_refuted_all_the_same():
    """A mean of squares that is a third too small, seven standard errors or so, is refuted by almost every sample."""
    rng = np.random.Generator(np.random.Philox(key=8))
    x = 2.0 / 3.0 * rng.standard_normal((200, PATHS)) ** 2
    t = (x.mean(axis=1) - 1.0) / (x.std(axis=1, ddof=1) / np.sqrt(PATHS))
    p = [correct_for_skewness(float(each), 2.0 * 2.0**0.5, PATHS) for each in scipy.special.ndtr(t)]

    assert np.mean(np.array(p) < 1e-5) > 0.99


def test_only_the_side_that_lacks_large_values_is_corrected():
    """No p-value falls; that of a symmetric variable, or of a mean that is too large, stays; more paths need less."""
    for p in (1e-12, 1e-5, 0.01, 0.3):
        assert correct_for_skewness(p, 0.0, PATHS) == correct_for_skewness(p, -2.0, PATHS) == p
        few, many = (correct_for_skewness(p, 2.0, paths) for paths in (PATHS, 100 * PATHS))
        assert 1.0 > few > many > p
    assert correct_for_skewness(0.7, 2.0, PATHS) == 0.7
    least = [correct_for_skewness(p, 5.0, PATHS) for p in (1e-20, 1e-100, 0.0)]
    assert least[0] == pytest.approx(least[1], rel=1e-12)
    assert least[1] == pytest.approx(least[2], rel=1e-12)
    assert least[0] > 1e-20
