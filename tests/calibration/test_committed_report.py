"""The committed calibration is that of the registered cases, as one command writes it."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from facade import Calibration, calibration_plan, load_registry, rate_table
from sdaeverify import Settings

FOLDER = Path(__file__).parents[2] / "reports" / "calibration"


@pytest.fixture(scope="module")
def committed():
    """Return the committed rates."""
    return pd.read_csv(FOLDER / "calibration.csv")


def test_report_is_at_the_default_settings(committed):
    """It is written by the command without options, and every rate agrees with what is promised."""
    text = (FOLDER / "calibration.md").read_text()

    assert "Made by `python -m sdaeverify calibrate` with seed" in text
    assert set(committed.seed) == {Settings().seed}
    assert committed.agrees.all()


def test_report_covers_the_registered_cases(committed):
    """Every registered case is in it."""
    cases = {case.rpartition(", ")[0] or case for case in committed.case}

    assert set(load_registry(environ={}, lab=True).things("sdaeverify_calibration")) <= cases


@pytest.mark.long
def test_rates_can_be_computed_again(committed):
    """A study gives the committed rates, up to a trial or two that another build's last bits may turn."""
    calibration = Calibration(
        calibration_plan(load_registry(environ={}, lab=True), Settings().seed, 1000, ["families"])
    )
    for _ in calibration.run():
        pass

    again = rate_table(calibration.rates, calibration.plan)
    hits = committed[committed.study == "families"].hits.to_numpy()
    assert np.abs(again.hits.to_numpy() - hits).max() <= 2
