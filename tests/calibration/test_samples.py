"""Blocks of repetitions on a real cell, and what the strong measure says of them."""

from dataclasses import replace

import numpy as np
import pytest

from facade import (
    POOLED,
    SEQUENCES_A_BLOCK,
    Strong,
    Weak,
    calibration_plan,
    join_samples,
    load_registry,
    published_rates,
    verdict_rates,
)
from sdaeverify.measuring import Evidence


@pytest.fixture(scope="module")
def sample():
    """Return one block of Euler-Maruyama on gbm, judged."""
    job, *_ = calibration_plan(load_registry(lab=True), 1, 40, ["verdicts euler-maruyama on gbm"]).jobs()
    return next(sample for sample in job.run() if sample.case.problem == "gbm")


def test_slopes_of_a_block_are_about_the_order(sample):
    """The errors of a block fall with the order of the case."""
    means = sample.errors[..., 1].sum(axis=(0, 1))

    assert sample.errors.shape == (SEQUENCES_A_BLOCK * POOLED, 20, 6, 3)
    assert np.polyfit(np.log2(sample.h), np.log2(means), 1)[0] == pytest.approx(sample.case.order, abs=0.05)


def test_verdicts_are_those_of_the_measure(sample):
    """The true order is not refuted, half an order more is, from paths alone and with local orders."""
    outcome, paths = sample.judged.outcome, sample.judged.paths

    assert set(outcome[:, 0].ravel()) <= {0.0, 1.0}
    np.testing.assert_array_equal(outcome[:, 1], -1.0)
    np.testing.assert_array_equal(outcome[:, 0, 1], 1.0)
    assert set(paths.ravel()) <= {100.0, 200.0, 400.0, 800.0, 1600.0}
    np.testing.assert_array_equal(paths[:, 1, 1], 100.0)


def test_published_intervals_lie_about_the_slope(sample):
    """The published interval is a proper one about the slope, and the asymptotic order has a half width."""
    judged = sample.judged

    assert (judged.low < judged.high).all()
    assert ((judged.low < 0.52) & (judged.high > 0.48)).all()
    assert (judged.half >= 0.05).all()


def test_rates_of_verdicts_name_what_is_wrong(sample):
    """Only verdicts that are wrong have a promise, and it is one of few."""
    rates = list(verdict_rates(sample))

    promised = [rate.statistic for rate in rates if rate.expected.high < 1.0]
    assert promised == [
        "true order refuted, paths alone",
        "order + 0.5 verified, paths alone",
        "true order refuted, with local orders",
        "order + 0.5 verified, with local orders",
    ]
    assert len(list(published_rates(sample))) == 2


def test_samples_are_joined_in_order(sample):
    """Two blocks make one sample of twice the sequences."""
    both = join_samples([sample, sample])

    assert both.sequences == 2 * sample.sequences == 2 * SEQUENCES_A_BLOCK
    assert len(both.judged.low) == both.sequences
    np.testing.assert_array_equal(both.errors[: len(sample.errors)], sample.errors)


def test_a_sequence_is_judged_at_its_own_level():
    """Every test at every look has the level 0.01/5: only the looks of one sequence share it."""
    levels = []

    class Recording(Strong):
        def judge(self, evidence: Evidence):
            levels.append(evidence.level)
            return super().judge(evidence)

    job, *_ = calibration_plan(load_registry(lab=True), 1, 40, ["verdicts milstein on gbm"]).jobs()
    replace(job, measures=(Recording(), Weak())).run()

    assert levels == pytest.approx([0.01 / 5] * len(levels))
