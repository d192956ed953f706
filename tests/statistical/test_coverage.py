"""Intervals contain the truth as often as they say, on seeds that the committed calibration does not use."""

import pytest

from facade import Calibration, Processes, available_cores, calibration_plan, load_registry, offending, summary

SEED = 2


@pytest.mark.long
def test_coverage_in_a_quick_sample():
    """On forty samples of 400 paths on gbm, no rate of the slope disagrees with what is promised for it."""
    calibration = Calibration(calibration_plan(load_registry(lab=True), SEED, 40, ["slope euler-maruyama on gbm"]))
    for _ in calibration.run():
        pass

    assert not offending(calibration.rates)


@pytest.mark.slow
def test_coverage_on_other_seeds(capsys):
    """On a thousand samples of 400 paths a case, no rate disagrees with what is promised for it."""
    calibration = Calibration(calibration_plan(load_registry(lab=True), SEED, 1000))
    with Processes(available_cores()) as executor:
        for _ in calibration.run(executor):
            pass

    with capsys.disabled():
        print("\n" + "\n".join(summary(calibration.rates)))
    assert not offending(calibration.rates)
