"""Intervals of stationary means from replicated chains."""

import pytest

from facade import calibration_plan, load_registry, offending


@pytest.fixture
def job():
    """Return the chains of one case, few of them."""
    (job,) = calibration_plan(load_registry(lab=True), 1, 200, ["chains*on ou"]).jobs()
    return job


def test_chains_cover(job):
    """Student's interval from sixteen chains keeps its promise, for each observable of the case."""
    rates = job.run()

    assert [rate.case.rpartition(", ")[2] for rate in rates] == list(job.case.stationary)
    assert {rate.trials for rate in rates} == {200}
    assert not offending(rates)


def test_too_narrow_an_interval_is_reported(job, monkeypatch):
    """Half the width is reported."""
    monkeypatch.setattr("scipy.special.stdtrit", lambda *_: 0.5 * 2.1314)

    assert len(offending(job.run())) == len(job.case.stationary)
