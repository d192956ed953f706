"""Coverage and tails of slopes on synthetic errors, for right estimators and for wrong ones."""

import numpy as np
import pytest

from facade import NOTHING, mean_difference_rates, offending, slope_rates, studies


def widened(factor):
    """Return the estimators with standard errors that are wrong by a factor."""
    right = studies.estimates

    def wrong(*arguments):
        found = right(*arguments)
        return found._replace(se=factor * found.se)

    return wrong


def test_true_slope_is_found(synthetic):
    """The slope of errors of size h is one, in every norm, and so is what it is compared with."""
    for norm in studies.NORMS:
        found, truth = studies.slopes(synthetic(), 4, norm)
        assert np.mean(found.value) == pytest.approx(1.0, abs=0.01)
        assert truth == pytest.approx(1.0, abs=0.01)


def test_jackknife_keeps_its_promises(synthetic):
    """On errors without heavy tails every rate of the slope agrees with what is promised."""
    rates = list(slope_rates(synthetic()))

    assert len(rates) == 3 * (3 + 4)
    assert not offending(rates)


@pytest.mark.parametrize(("factor", "too"), [(0.5, "narrow"), (2.0, "wide")])
def test_wrong_intervals_are_reported(synthetic, monkeypatch, factor, too):
    """Intervals of half or of twice their width are reported, and half of it shows in the tails, as well."""
    monkeypatch.setattr(studies, "estimates", widened(factor))

    named = {rate.statistic for rate in offending(list(slope_rates(synthetic())))}

    assert {"L1 interval, 95 %", "L1/2 interval, 95 %"} <= named
    assert ("L1 slope taken for too low at 0.01" in named) is (too == "narrow")


def test_nothing_is_promised_for_few_paths_of_heavy_tails(synthetic):
    """Where the mean rests on few paths the promise begins with the sample size from which verdicts are given."""
    sample = synthetic(40)
    heavy = sample._replace(case=sample.case.__class__(scheme="s", problem="p", order=1.0, heavy=True))

    promised = {rate.paths for rate in slope_rates(heavy) if rate.expected != NOTHING}

    assert promised == {1600}


def test_weak_slopes_are_covered(synthetic):
    """Differences of means that are resolved have slopes whose intervals keep their promise."""
    rates = list(mean_difference_rates(synthetic()))

    assert [rate.paths for rate in rates] == [400, 1600]
    assert NOTHING not in {rate.expected for rate in rates}
    assert not offending(rates)


def test_unresolved_weak_slopes_have_no_promise(synthetic):
    """Where noise covers the differences the rate is shown and nothing is promised."""
    sample = synthetic(40)
    noisy = {"values x": sample.weak.sums["values x"] + np.random.default_rng(5).normal(size=(640, 20, 6))}
    weak = sample.weak.__class__(sums={**sample.weak.sums, **noisy})

    assert {rate.expected for rate in mean_difference_rates(sample._replace(weak=weak))} == {NOTHING}
