"""The command ``calibrate``: options, files, exit codes."""

from pathlib import Path

import pytest

from evidence import rows_of
from facade import studies

QUICK = ("calibrate", "--repetitions", "40", "-j", "1", "--progress", "none")


def test_calibrate_writes_its_tables(call):
    """The tables go into the folder, with the command that makes them again, and every rate agrees."""
    outcome = call(*QUICK, "--only", "chains*on ou", "--out", "here", "--seed", "7")

    assert outcome.code == 0
    assert "exit code 0: no claim is refuted, and no check fails" in outcome.out
    assert {row["seed"] for row in rows_of("here/calibration.csv")} == {"7"}
    text = Path("here", "calibration.md").read_text()
    assert "`python -m sdaeverify calibrate --repetitions 40 --seed 7 --only 'chains*on ou' --out here`" in text


@pytest.mark.long
def test_rates_that_disagree_are_named(call, monkeypatch):
    """An interval of half its width ends with exit code 1 and the rows that show it."""
    right = studies.estimates

    def wrong(*arguments):
        found = right(*arguments)
        return found._replace(se=0.5 * found.se)

    monkeypatch.setattr(studies, "estimates", wrong)

    outcome = call(*QUICK, "--only", "slope milstein on gbm")

    assert outcome.code == 1
    assert "disagrees: slope, milstein on gbm, L1 interval, 95 %, 100 paths" in outcome.out
    assert "exit code 1: a claim is refuted, or a check fails" in outcome.out
