"""What plugins answer in workers that die of asking."""

import pickle
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from sdaeverify.contracts.finding import Verdict
from sdaeverify.contracts.specs import problem_spec
from sdaeverify.measures.strong import Strong
from sdaeverify.measures.weak import Weak
from sdaeverify.simulate.marker import NO_MEASURE, PROBLEM
from sdaeverify.study.plan import plan
from sdaeverify.study.remote_plan import remote_plan
from sdaeverify.workers.calls import DIED
from sdaeverify.workers.isolated import Died, Isolated
from sdaeverify.workers.limits import FORMAT, NOBODY, Limits
from sdaeverify_problems.gbm import gbm
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.stochastic_theta import StochasticTheta

SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
MEASURES = (Strong(), Weak())
GBM = problem_spec(gbm)
WHEN = 100.0
DEAD = f"{DIED}, perhaps for want of memory"


class Fragile(Isolated):
    """Dies where Milstein is asked, with a mark of who is said to have done it."""

    def __init__(self, folder, blamed=None, deadline=float("inf")):
        super().__init__(None, 1, Limits(5.0), folder)
        self.blamed, self.deadline = blamed, deadline

    def submit(self, fn, /, *args):
        """Make a call, or die of it."""
        names = [scheme.name for scheme in pickle.loads(args[0]).schemes]
        future = Future()
        if self.blamed is not None and "milstein" in names:
            lane = names.index("milstein") if self.blamed == "milstein" else self.blamed
            args[1].write_bytes(FORMAT.pack(lane, NO_MEASURE, self.deadline))
            future.set_exception(Died("it died", WHEN))
        else:
            future.set_result(fn(*args))
        return future


class Unclaimed(Strong):
    """Nobody claims anything about it, and it may not be asked."""

    name = "unclaimed"

    def refuses(self, scheme, problem):
        """Fail."""
        raise AssertionError


def told(executor):
    """Return what is told of a problem."""
    return remote_plan(executor, SCHEMES, [GBM], MEASURES)(GBM)


def failures(found):
    """Return the reasons of cells that failed, by scheme and measure."""
    return {(c.scheme.name, c.measure.name): c.reason for c in found.cells if c.verdict is Verdict.ERROR}


def test_everybody_answers(tmp_path):
    """Each measure of each scheme has its cell, and no mark stays."""
    found = told(Fragile(tmp_path))

    assert [(c.scheme, c.measure.name) for c in found.cells] == [(s, m) for s in SCHEMES for m in ("strong", "weak")]
    assert found.builds
    assert not failures(found)
    assert not list(tmp_path.iterdir())


def test_only_what_is_claimed(tmp_path):
    """Where only claimed cells are wanted, a scheme is asked about no other measure, neither there nor here."""

    def cells(*measures):
        planner = remote_plan(Fragile(tmp_path), SCHEMES, [GBM], measures, claimed=True)
        made = plan(SCHEMES, [GBM], measures, planner=planner)
        return [(cell.scheme, cell.measure.name, cell.verdict) for cell in made.cells]

    assert cells(Strong(), Unclaimed()) == [(scheme, "strong", None) for scheme in SCHEMES]
    assert not cells(Unclaimed())


@pytest.mark.parametrize(
    ("deadline", "why"), [(WHEN, "no answer within 5 s (--timeout)"), (WHEN + 1.0, DEAD)], ids=["late", "dead"]
)
def test_who_dies_of_being_asked(tmp_path, deadline, why):
    """It costs its own cells; the others are as they are without it."""
    whole = told(Fragile(tmp_path))

    found = told(Fragile(tmp_path, "milstein", deadline))

    assert found.builds
    assert failures(found) == {("milstein", "strong"): why, ("milstein", "weak"): why}
    others = [cell for cell in whole.cells if cell.scheme.name != "milstein"]
    assert [cell for cell in found.cells if cell.scheme.name != "milstein"] == others
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("lane", [PROBLEM, NOBODY], ids=["problem", "nobody"])
def test_a_problem_that_ends_the_process(tmp_path, lane):
    """Where no scheme's code ran, it is said that the problem cannot be built."""
    found = told(Fragile(tmp_path, lane))

    assert not found.builds
    assert set(failures(found).values()) == {f"problem gbm cannot be built: {DEAD}"}
    assert len(found.cells) == 6


@pytest.mark.parametrize("lane", [PROBLEM, NOBODY, "milstein"], ids=["problem", "nobody", "scheme"])
def test_who_is_killed_once_is_asked_again(tmp_path, lane):
    """A process that is killed from elsewhere costs nothing."""

    class Once(Fragile):
        def submit(self, fn, /, *args):
            future = super().submit(fn, *args)
            self.blamed = None
            return future

    found = told(Once(tmp_path, lane))

    assert found.builds
    assert not failures(found)
    assert found.cells == told(Fragile(tmp_path)).cells


def test_there_is_nobody_to_ask():
    """Without isolated workers, plugins are asked in this process."""
    with ThreadPoolExecutor(1) as executor:
        assert remote_plan(executor, SCHEMES, [GBM], MEASURES) is None
    assert remote_plan(None, SCHEMES, [GBM], MEASURES) is None
