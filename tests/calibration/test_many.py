"""Many repetitions at once: the same numbers as one by one, and truths that are independent of them."""

import numpy as np

from facade import estimates, opposite
from sdaeverify.measuring import jackknife
from sdaeverify.numerics import GROUPS


def test_estimates_are_those_of_the_jackknife():
    """Each repetition's estimate is, to the last bits, what the jackknife gives for it alone."""
    rng = np.random.default_rng(2)
    sums, counts = rng.lognormal(size=(7, GROUPS, 3)), np.full(GROUPS, 5.0)

    found = estimates(sums, counts, lambda means: np.log2(means[0] / means[2]))

    alone = [jackknife(one, counts, lambda means: float(np.log2(means[0] / means[2]))) for one in sums]
    np.testing.assert_allclose(found.value, [one.value for one in alone], rtol=1e-12)
    np.testing.assert_allclose(found.se, [one.se for one in alone], rtol=1e-12)


def test_truth_is_of_the_other_half():
    """A repetition is compared with the mean of the half of the sequences that it is not in."""
    values = np.repeat(np.array([1.0, 2.0, 6.0]), 4)[:, None]

    truth = opposite(values, lambda mean: mean[0], sequences=3, repetitions=6)

    np.testing.assert_array_equal(truth, [4.0, 4.0, 1.0, 1.0, 1.0, 1.0])
