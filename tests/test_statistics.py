"""Order estimates: exact on exact data, jackknife as its definition says."""

import numpy as np
import pytest
from scipy import stats

from facade import corrected_slope_weights, log_functional
from sdaeverify.measuring import Estimate, group_sums, jackknife
from sdaeverify.numerics import GROUPS, Tail, clopper_pearson, log_norms, slope_weights

X = np.log2(1.0 / np.array([8, 16, 32, 64, 128]))


def test_slope_weights_give_the_least_squares_slope():
    """The weights agree with a polynomial fit to rounding."""
    y = np.random.default_rng(1).normal(size=X.size)

    assert slope_weights(X) @ y == pytest.approx(np.polyfit(X, y, 1)[0], rel=1e-12)


def test_corrected_slope_sees_through_a_linear_correction():
    """Y = a + p x + c h has the asymptotic order p whatever c is."""
    y = 3.0 + 0.5 * X + 7.0 * 2.0**X

    assert corrected_slope_weights(X) @ y == pytest.approx(0.5, abs=1e-10)


def test_log_norm_is_the_logarithm_of_the_norm():
    """log2 (E e^p)^(1/p) of a constant error is its logarithm for every p."""
    for p in (0.5, 1.0, 2.0):
        assert log_norms(np.array([0.25**p]), p)[0] == pytest.approx(-2.0, rel=1e-14)


def test_group_sums_take_every_twentieth_path():
    """Path i belongs to group i mod 20, also where a block is smaller than the number of groups."""
    sums = group_sums(np.arange(45.0)[None])

    assert sums.shape == (GROUPS, 1)
    assert sums[3, 0] == 3 + 23 + 43
    assert group_sums(np.ones(7)).sum() == 7


def test_jackknife_of_the_mean_is_the_classical_standard_error():
    """For a mean, pseudo-values are the group means and the error is their standard deviation over sqrt(G)."""
    values = np.random.default_rng(2).normal(size=400)
    sums, counts = group_sums(values), group_sums(np.ones(400))

    estimate = jackknife(sums, counts, float)

    means = sums / counts
    assert estimate.value == pytest.approx(values.mean(), rel=1e-10)
    assert estimate.se == pytest.approx(means.std(ddof=1) / np.sqrt(GROUPS), rel=1e-10)


def test_jackknife_removes_the_bias_of_a_quadratic():
    """The square of a mean is biased by its variance over n; pseudo-values correct that to second order."""
    values = np.random.default_rng(3).normal(size=(2000, 40))
    counts = group_sums(np.ones(40))

    corrected = [jackknife(group_sums(row), counts, lambda mean: float(mean**2)).value for row in values]

    # The true value is 0 and the plain estimator's mean 1/40; 2000 repetitions know it to 8e-4.
    spread = np.std(corrected) / np.sqrt(len(values))
    assert abs(np.mean(corrected)) < stats.norm.ppf(1 - 5e-7) * spread
    assert np.mean(values.mean(axis=1) ** 2) > 10 * spread


@pytest.mark.parametrize("levels", [1, 2, 3, 4, 6, 9])
def test_all_groups_at_once_have_the_bits_of_each_by_itself(levels):
    """A sum over levels is taken in the same order, whatever the layout of the sums over groups."""
    draw = np.random.default_rng(levels)
    sums = draw.random((GROUPS, 9, 4))[:, draw.permutation(9)[:levels], 1]
    counts, weights = np.full(GROUPS, 13.0), draw.normal(size=levels)
    one = jackknife(sums, counts, lambda means: float(np.einsum("l,l->", weights, np.log2(means) / 2.0)))
    assert log_functional(sums, counts, weights, 2.0) == one


def test_interval_is_students_widened_by_the_bias():
    """The interval uses Student's t with 19 degrees of freedom and adds the bias bound on either side."""
    low, high = Estimate(1.0, 0.1).interval(0.95, bias=0.02)

    half = stats.t.ppf(0.975, 19) * 0.1 + 0.02
    assert (low, high) == pytest.approx((1.0 - half, 1.0 + half), rel=1e-12)


def test_equal_errors_have_a_light_tail():
    """Equal errors use the whole sample."""
    found = Tail.of(100.0, 100.0, np.ones(10), 100)

    assert found.effective == 1.0
    assert not found.heavy


def test_one_dominating_path_is_a_heavy_tail():
    """A sum that rests on one path is flagged."""
    errors = np.r_[np.ones(99), 1000.0]

    assert Tail.of(errors.sum(), (errors**2).sum(), np.sort(errors)[::-1][:10], 100).heavy


def test_hill_index_of_a_pareto_sample():
    """The Hill index of a Pareto tail is its exponent, within four standard errors."""
    errors = np.sort(np.random.default_rng(4).pareto(1.5, size=250_000) + 1.0)[::-1]

    found = Tail.of(errors.sum(), (errors**2).sum(), errors[:500], len(errors))

    assert found.hill == pytest.approx(1.5, abs=4 * 1.5 / np.sqrt(500))
    assert found.heavy


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

    assert stats.binom.pmf(np.arange(41), 40, p)[covering].sum() >= 0.9
