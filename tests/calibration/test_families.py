"""Families of tests with Holm's procedure."""

import numpy as np

from facade import family_rates, offending, studies


def test_holm_keeps_its_promise():
    """Without correction a run errs as often as five independent tests do, with Holm's procedure hardly ever."""
    rates = {rate.statistic: rate for rate in family_rates(seed=1, runs=300)}

    assert not offending(list(rates.values()))
    assert rates["false refutation, uncorrected"].interval()[0] > 0.05
    assert rates["false refutation, Holm"].rate <= 0.05


def test_a_procedure_that_corrects_nothing_is_reported(monkeypatch):
    """Tests at level alpha each, in the place of Holm's procedure, are reported."""
    monkeypatch.setattr(studies, "holm", lambda p, alpha: {place for place, value in p.items() if value <= alpha})

    named = {rate.statistic for rate in offending(list(family_rates(seed=1, runs=300)))}

    assert {"false refutation, Holm", "false verification, Holm"} <= named


def test_seed_decides():
    """The same seed gives the same rates, another one others."""
    first, again, other = (list(family_rates(seed, runs=40)) for seed in (1, 1, 2))

    assert first == again
    assert first != other
    assert np.isnan(first[0].paths)
