"""What plugins answer in workers that die of asking."""

import pickle
import time
from concurrent.futures import Future, ThreadPoolExecutor

import pytest
from pebble import ProcessExpired

from facade import (
    DIED,
    FORMAT,
    NO_MEASURE,
    NOBODY,
    PROBLEM,
    EulerMaruyama,
    Limits,
    Milstein,
    Processes,
    StochasticTheta,
    Strong,
    Weak,
    gbm,
    plan,
    problem_spec,
)
from sdaeverify.measuring import Verdict
from sdaeverify.study.trial import trial_of

SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
MEASURES = (Strong(), Weak())
GBM = problem_spec(gbm)
DEAD = f"{DIED} with exit code 3, twice"


class Fragile(Processes):
    """Dies where Milstein is asked, with a mark of who is said to have done it."""

    active = True

    def __init__(self, folder, blamed=None, deadline=float("inf")):
        super().__init__(1, (), Limits(5.0), folder)
        self.blamed, self.deadline = blamed, deadline

    def submit(self, fn, /, *args):
        """Make a call, or die of it or never come back."""
        _, argument, mark, _ = args
        names = [entry.scheme.name for entry in pickle.loads(argument).entries]
        future = Future()
        if self.blamed is not None and "milstein" in names:
            scheme = names.index("milstein") if self.blamed == "milstein" else self.blamed
            mark.write_bytes(FORMAT.pack(scheme, NO_MEASURE, self.deadline))
            if self.deadline > time.monotonic():
                future.set_exception(ProcessExpired("it died", code=3))
        else:
            future.set_result(fn(*args))
        return future


def planned(executor):
    """Return the plan of a problem."""
    (made,) = plan(SCHEMES, [GBM], MEASURES, trial=trial_of(executor, SCHEMES, [GBM], MEASURES)).problems
    return made


def failures(made):
    """Return the reasons of cells that failed, by scheme and measure."""
    return {(c.scheme.name, c.measure.name): c.reason for c in made.cells if c.verdict is Verdict.ERROR}


def test_everybody_answers(tmp_path):
    """Each measure of each scheme has its cell, as without processes, and no mark stays."""
    made = planned(Fragile(tmp_path))

    assert made.cells == planned(None).cells
    assert [(c.scheme, c.measure.name) for c in made.cells] == [(s, m) for s in SCHEMES for m in ("strong", "weak")]
    assert not failures(made)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("deadline", "why"), [(0.0, "no answer within 5 s (--timeout)"), (float("inf"), DEAD)], ids=["late", "dead"]
)
def test_who_dies_of_being_asked(tmp_path, deadline, why):
    """It costs its own cells; the others are as they are without it."""
    whole = planned(Fragile(tmp_path))

    made = planned(Fragile(tmp_path, "milstein", deadline))

    assert failures(made) == {("milstein", "strong"): why, ("milstein", "weak"): why}
    others = [cell for cell in whole.cells if cell.scheme.name != "milstein"]
    assert [cell for cell in made.cells if cell.scheme.name != "milstein"] == others
    assert not list(tmp_path.iterdir())


def test_a_problem_that_ends_the_process(tmp_path):
    """Where no scheme's code ran, it is said that the problem cannot be built, and it is not built here."""
    made = planned(Fragile(tmp_path, PROBLEM))

    assert made.problem is None
    assert set(failures(made).values()) == {f"problem gbm cannot be built: {DEAD}"}
    assert len(made.cells) == 6


@pytest.mark.parametrize("blamed", [PROBLEM, NOBODY, "milstein"], ids=["problem", "nobody", "scheme"])
def test_who_is_killed_once_is_asked_again(tmp_path, blamed):
    """A process that is killed from elsewhere costs nothing."""

    class Once(Fragile):
        def submit(self, fn, /, *args):
            future = super().submit(fn, *args)
            self.blamed = None
            return future

    made = planned(Once(tmp_path, blamed))

    assert not failures(made)
    assert made.cells == planned(Fragile(tmp_path)).cells


def test_there_is_nobody_to_ask():
    """Without isolated workers, plugins are asked in this process."""
    with ThreadPoolExecutor(1) as executor:
        assert trial_of(executor, SCHEMES, [GBM], MEASURES) is None
    assert trial_of(None, SCHEMES, [GBM], MEASURES) is None
