"""What plugins answer in workers that die of asking."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from facade import (
    NO_MEASURE,
    PROBLEM,
    EulerMaruyama,
    Milstein,
    StochasticTheta,
    Strong,
    Weak,
    gbm,
    plan,
    problem_spec,
)
from sdaeverify.measuring import Verdict
from sdaeverify.study.trial import trial_of

from .fragile import BOTH, TWICE, blaming

SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
MEASURES = (Strong(), Weak())
GBM = problem_spec(gbm)


def planned(executor):
    """Return the plan of a problem."""
    (made,) = plan(SCHEMES, [GBM], MEASURES, trial=trial_of(executor, SCHEMES, [GBM], MEASURES)).problems
    return made


def failures(made):
    """Return the reasons of cells that failed, by scheme and measure."""
    return {(c.scheme.name, c.measure.name): c.reason for c in made.cells if c.verdict is Verdict.ERROR}


def test_everybody_answers(fragile):
    """Each measure of each scheme has its cell, as without processes, and no mark stays."""
    executor = fragile()
    made = planned(executor)

    assert made.cells == planned(None).cells
    assert [(c.scheme, c.measure.name) for c in made.cells] == [(s, m) for s in SCHEMES for m in ("strong", "weak")]
    assert not failures(made)
    assert not executor.marks


@pytest.mark.parametrize(
    ("deadline", "why"), [(0.0, "no answer within 5 s (--timeout)"), (float("inf"), TWICE)], ids=["late", "dead"]
)
def test_who_dies_of_being_asked(fragile, deadline, why):
    """It costs its own cells; the others are as they are without it."""
    made = planned(fragile(BOTH, blaming("milstein"), deadline))

    assert failures(made) == dict.fromkeys(BOTH, why)
    others = [cell for cell in planned(None).cells if cell.scheme.name != "milstein"]
    assert [cell for cell in made.cells if cell.scheme.name != "milstein"] == others


def test_a_problem_that_ends_the_process(fragile):
    """Where no scheme's code ran, it is said that the problem cannot be built, and it is not built here."""
    made = planned(fragile(BOTH, lambda _: (PROBLEM, NO_MEASURE)))

    assert made.problem is None
    assert set(failures(made).values()) == {f"problem gbm cannot be built: {TWICE}"}
    assert len(made.cells) == 6


def test_there_is_nobody_to_ask():
    """Without isolated workers, plugins are asked in this process."""
    with ThreadPoolExecutor(1) as executor:
        assert trial_of(executor, SCHEMES, [GBM], MEASURES) is None
    assert trial_of(None, SCHEMES, [GBM], MEASURES) is None
