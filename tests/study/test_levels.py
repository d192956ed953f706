"""Rows of levels that a measure returns."""

from typing import ClassVar

import pytest

from sdaeverify import verify
from sdaeverify.measuring import Finding, Judgement, LevelFinding, Measure, Tally, Verdict


class Counting(Measure):
    """Number of paths, at a level of its own choice."""

    name: ClassVar[str] = "counting"
    level: ClassVar[int] = 0

    def observer(self, problem, parts, settings):
        return Idle(settings)

    def judge(self, evidence):
        found = Finding(quantity="x", verdict=Verdict.OUT_OF_SCOPE, estimate=1.0)
        return Judgement((found,), [LevelFinding("x", self.level, 1.0)])


class Idle:
    """An observer that observes nothing."""

    def __init__(self, settings):
        self.wanted = [frozenset()] * settings.levels

    def after_step(self, level, step, parts):
        pass

    def after_coarsest_step(self, snapshot):
        pass

    def tally(self):
        return Tally()


@pytest.mark.parametrize("level", [-1, 4, 100])
def test_a_level_that_was_not_simulated_is_an_error_of_the_measure(level):
    """The cell is in error with one line, and the other cells of the run are judged."""
    wrong = type("Wrong", (Counting,), {"name": "wrong", "level": level})()
    rows = verify("euler-maruyama", "gbm", [wrong, "strong"], paths=256, coarsest=8, levels=4).verdicts
    by_measure = rows.set_index("measure")

    assert by_measure.verdict["wrong"] == "error"
    assert f"names level {level}, expected 0 to 3 or None" in by_measure.reason["wrong"]
    assert not (by_measure.verdict["strong"] == "error").any()


def test_a_level_of_the_run_is_a_row():
    """A level that was simulated has its step size and its number of paths."""
    levels = verify("euler-maruyama", "gbm", Counting(), paths=256, coarsest=8, levels=4).levels
    assert levels[["h", "paths"]].to_numpy().tolist() == [[0.125, 256]]
