"""Factors between errors whose law is known, without any simulation."""

import numpy as np
import pytest
from scipy.stats import binom

from facade import leave_out
from sdaeverify import UsageError
from sdaeverify.measuring import group_sums
from sdaeverify_runs.changes import Change, changes
from sdaeverify_runs.factors import IS_EXACT, ORDER_ALONE, WAS_EXACT, factor
from sdaeverify_runs.level_errors import NO_LEVELS, LevelErrors

H = 2.0 ** -np.arange(3.0, 9.0)
PATHS = 256


def sizes(errors, h=H):
    """Return sizes from errors of shape (levels, paths)."""
    counts = group_sums(np.ones(errors.shape[-1]))
    return LevelErrors(h, np.log2(leave_out(group_sums(errors), counts)), np.ones(len(h), dtype=bool), counts)


def known(values, h=H):
    return LevelErrors(h, np.log2(values)[np.newaxis], np.ones(len(h), dtype=bool))


def untold(found):
    return found._replace(told=np.zeros(len(found.h), dtype=bool))


@pytest.fixture
def errors():
    """Return errors of order 1/2 with a log-normal factor that all step sizes share."""
    rng = np.random.default_rng(1)
    common = np.exp(0.6 * rng.standard_normal(PATHS))
    return np.sqrt(H)[:, None] * common * np.exp(0.2 * rng.standard_normal((len(H), PATHS)))


def test_identical_errors_have_the_factor_one(errors):
    """Not nearly one: what is the same on every path cancels to the last bit, and so does its interval."""
    found = factor(sizes(errors), sizes(errors))

    assert found.log2 == (0.0, 0.0)
    assert changes([found]) == [(1.0, 1.0, 1.0, Change.SAME, False)]


def test_doubled_errors_are_worse_and_halved_ones_better(errors):
    """The factor is the ratio of errors, new over old, whichever has grown."""
    grown, shrunk = factor(sizes(errors), sizes(2.0 * errors)), factor(sizes(2.0 * errors), sizes(errors))
    worse, better = changes([grown, shrunk])

    assert (worse.change, better.change) == (Change.WORSE, Change.BETTER)
    assert (worse.factor, better.factor) == pytest.approx((2.0, 0.5))
    assert grown.sampled
    assert grown.levels == 4


def test_pairing_tells_what_independent_samples_do_not(errors):
    """An error that grows by a fifth is seen on common noise, and lost in the scatter of errors on other noise."""
    rng = np.random.default_rng(2)
    other = np.sqrt(H)[:, None] * np.exp(0.6 * rng.standard_normal(PATHS)) * np.ones((len(H), 1))
    paired, unpaired = factor(sizes(errors), sizes(1.2 * errors)), factor(sizes(errors), sizes(1.2 * other))

    assert changes([paired])[0].change is Change.WORSE
    assert changes([unpaired])[0].change is Change.UNDECIDED


def test_a_change_within_the_margin_is_none(errors):
    """What is significant but small is the same; with a smaller margin it is worse."""
    found = factor(sizes(errors), sizes(1.05 * errors))

    assert changes([found])[0].change is Change.SAME
    assert changes([found], margin=1.02)[0].change is Change.WORSE


def test_only_common_finest_levels_count(errors):
    """The mean is taken over the finest four of the step sizes that both runs could use."""
    grown = errors * np.array([50.0, 2.0, 2.0, 2.0, 2.0, 9.0])[:, None]
    found = factor(sizes(errors), sizes(grown[:-1], H[:-1]))

    assert changes([found])[0].factor == pytest.approx(2.0)
    assert found.levels == 4


def test_errors_known_without_sampling_are_compared_as_they_are():
    """Their factor has no interval, and is worse from the margin on."""
    found = factor(known(H), known(1.2 * H))

    assert not found.sampled
    (changed,) = changes([found])
    assert changed[:3] == pytest.approx((1.2, 1.2, 1.2))
    assert changed.change is Change.WORSE
    assert changes([found], margin=1.3)[0].change is Change.SAME


@pytest.mark.parametrize("rounding", [0.0, 2.0**-50])
def test_rounding_that_has_become_an_error_is_worse(errors, rounding):
    """Who was exact and is not any more has lost everything, and the other way round."""
    with np.errstate(divide="ignore"):
        exact = untold(sizes(rounding * errors))
    found = [factor(exact, sizes(errors)), factor(sizes(errors), exact)]

    assert [each.reason for each in found] == [WAS_EXACT, IS_EXACT]
    assert [each.change for each in changes(found)] == [Change.WORSE, Change.BETTER]
    assert changes(found)[0].factor == np.inf
    assert not factor(exact, exact).known


def test_an_order_that_is_known_without_errors():
    """Where no error is told, an order that falls is worse, one that rises better, and one that stays the same."""
    orders = [(2.0, 1.0), (1.0, 2.0), (1.0, 1.0)]
    found = [factor(*(NO_LEVELS._replace(order=order) for order in pair)) for pair in orders]
    judged = changes(found)

    assert {each.reason for each in found} == {ORDER_ALONE}
    assert [each.change for each in judged] == [Change.WORSE, Change.BETTER, Change.SAME]
    assert [each.order_moved for each in judged] == [True, True, False]


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (lambda e: sizes(e[:, :200]), "256 paths in one run, 200 in the other"),
        (lambda e: known(np.sqrt(H)), "sampled in one run only"),
        (lambda e: sizes(e, h=3.0 * H), "no step size at which both errors exceed their noise"),
        (lambda e: untold(sizes(e)), "no step size"),
    ],
)
def test_what_cannot_be_compared_says_why(errors, other, words):
    """Other paths, other step sizes and errors that are not there give no factor but a reason."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = factor(sizes(errors), other(errors))

    assert not found.known
    assert words in found.reason


def test_few_paths_tell_nothing(errors):
    """Below the number of paths from which on intervals are calibrated there is no factor."""
    few = sizes(errors[:, :60])

    assert "60 common paths" in factor(few, few).reason


@pytest.mark.parametrize(("margin", "alpha"), [(1.0, 0.01), (np.nan, 0.01), (1.1, 0.0), (1.1, 0.7)])
def test_margins_and_levels_out_of_range(margin, alpha):
    """They are refused in one line."""
    with pytest.raises(UsageError, match="must be above"):
        changes([], margin, alpha)


def false_alarms(trials, alpha, *, tests=1, paths=PATHS):
    """Count the runs in which an error that has grown by exactly the margin is called worse."""
    rng, alarms = np.random.default_rng(3), 0
    for _ in range(trials):
        found = [at_the_margin(rng, paths) for _ in range(tests)]
        alarms += any(each.change is Change.WORSE for each in changes(found, 1.1, alpha))
    return alarms


def at_the_margin(rng, paths, scatter=0.3):
    common = np.sqrt(H)[-4:, None] * np.exp(0.6 * rng.standard_normal(paths))
    mean = np.exp(0.5 * scatter**2)
    old, new = (common * np.exp(scatter * rng.standard_normal(common.shape)) / mean for _ in range(2))
    return factor(sizes(old, H[-4:]), sizes(1.1 * new, H[-4:]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("alpha", "tests", "paths"), [(0.05, 1, 256), (0.01, 1, 256), (0.05, 1, 100), (0.05, 8, 256)]
)
def test_false_alarms_stay_at_the_level(alpha, tests, paths):
    """A factor exactly at the margin is called worse at most as often as the level says, for all tests together."""
    trials = 4000 // tests
    bound = binom.isf(1e-4, trials, alpha)

    assert false_alarms(trials, alpha, tests=tests, paths=paths) <= bound


@pytest.mark.slow
def test_the_level_is_used():
    """The test is not idle: at the margin it errs nearly as often as it may."""
    assert false_alarms(4000, 0.05) >= binom.ppf(1e-4, 4000, 0.035)


def test_an_order_that_falls_has_moved(errors):
    """Errors that are the same at the coarsest step and fall more slowly have another order, without scatter."""
    slower = errors * (H / H[0])[:, None] ** -0.25
    found = factor(sizes(errors), sizes(slower))
    (changed,) = changes([found])

    assert found.order == pytest.approx((-0.25, 0.0), abs=1e-10)
    assert changed.order_moved
