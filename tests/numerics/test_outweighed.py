"""One test of sizes is Student's, with the degrees of freedom of its groups."""

import numpy as np
import pytest
import scipy.stats

from sdaeverify.numerics import outweighs, sample_growth
from sdaeverify.numerics.outweighed import t_values


@pytest.mark.parametrize("groups", [2, 20, 32])
def test_size_against_zero_is_two_sided_t_test(groups):
    """Against nothing the p-value is that of the two-sided t-test on so many groups."""
    a = np.random.default_rng(groups).normal(0.3, 1.0, (groups, 5))
    expected = scipy.stats.ttest_1samp(a, 0.0)

    np.testing.assert_allclose(t_values(a), expected.statistic, rtol=1e-12)
    np.testing.assert_allclose(outweighs(a), expected.pvalue, rtol=1e-9)


@pytest.mark.parametrize("groups", [20, 32])
def test_foretold_sample_decides(groups):
    """A sample that has grown by what is foretold, with the same figures, has the p-value that is needed."""
    noise = scipy.stats.zscore(np.arange(float(groups)), ddof=1)
    a = 2.0 / np.sqrt(groups) + noise
    needed = 1e-6

    more = sample_growth(float(outweighs(a)), needed, groups)
    grown = a.mean() + noise / np.sqrt(more)

    np.testing.assert_allclose(outweighs(grown), needed, rtol=1e-9)
