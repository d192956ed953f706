"""Blocks over an executor whose workers die: evidence is that of the scheme it is about."""

import pickle
from collections import deque
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import pytest

from sdaeverify import Settings
from sdaeverify.contracts.specs import problem_spec
from sdaeverify.measures.strong import Strong
from sdaeverify.measures.weak import Weak
from sdaeverify.simulate.ensemble import Entry, Task, run_block
from sdaeverify.simulate.marker import NO_MEASURE, PROBLEM
from sdaeverify.study.blocks import Blocks, Portion
from sdaeverify.workers.calls import DIED, Lost
from sdaeverify.workers.executors import Crew
from sdaeverify.workers.isolated import Died, Isolated
from sdaeverify.workers.limits import FORMAT, NOBODY, Limits, Mark
from sdaeverify_problems.gbm import gbm
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.stochastic_theta import StochasticTheta

SETTINGS = Settings(paths=40, block=40, levels=3, coarsest=2)
SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
STRONG, WEAK = Strong(), Weak()
TASK = Task(problem_spec(gbm), tuple(Entry(scheme, (STRONG, WEAK)) for scheme in SCHEMES), SETTINGS)


class Given(NamedTuple):
    """A job."""

    task: Task
    block: int


class Here(Executor):
    """Makes calls in this process."""

    def submit(self, call):
        """Make a call at once."""
        future = Future()
        try:
            future.set_result(call())
        except Died as error:
            future.set_exception(error)
        return future


class Fragile(Isolated):
    """Dies where a parcel holds a scheme and a measure, with a mark of who is said to have done it."""

    def __init__(self, folder, guilty, blamed, deadline=float("inf")):
        super().__init__(Here, 1, Limits(5.0), folder)
        self.guilty, self.blamed, self.deadline, self.parcels = guilty, blamed, deadline, []

    def submit(self, fn, /, *args):
        """Make a call, or die of it."""
        parcel, mark, _ = args
        loaded = pickle.loads(parcel)
        names = [(e.scheme.name, m.name) for e in loaded.task.entries for m in e.measures]
        self.parcels.append(names)
        future = Future()
        if any(pair in names for pair in self.guilty):
            mark.write_bytes(FORMAT.pack(*self.blamed(loaded.task.entries), self.deadline))
            future.set_exception(Died("it died", 100.0))
        else:
            future.set_result(run_block(loaded.task, loaded.block))
        return future


def blaming(name, measure=NO_MEASURE):
    """Return a function that blames a scheme by its name, wherever it is."""

    def blamed(entries):
        index = next((i for i, entry in enumerate(entries) if entry.scheme.name == name), NOBODY)
        one = measure != NO_MEASURE and index != NOBODY
        where = [m.name for m in entries[index].measures].index(measure) if one else NO_MEASURE
        return index, where

    return blamed


def errors(executor):
    """Return what became of the schemes, and check that every good one has its own numbers."""
    found = [found for _, found in Blocks(executor, None).results(deque([Given(TASK, 0)]), 1)]
    (lanes,) = [one for one in found if not isinstance(one, Portion)]
    for lane, whole in zip(lanes, run_block(TASK, 0), strict=True):
        for index, error in enumerate(lane.errors):
            if not error:
                one, other = lane.tallies[index], whole.tallies[index]
                assert {n: v.tolist() for n, v in one.sums.items()} == {n: v.tolist() for n, v in other.sums.items()}
    return [lane.errors for lane in lanes]


TWICE = f"{DIED}, perhaps for want of memory, twice"
BOTH = {("milstein", "strong"), ("milstein", "weak")}


def test_nobody_dies(tmp_path):
    """Good schemes are run together, once."""
    executor = Fragile(tmp_path, set(), blaming(""))

    assert errors(executor) == [("", "")] * 3
    assert len(executor.parcels) == 1


@pytest.mark.parametrize("blamed", ["milstein", "nobody"], ids=["marked", "unmarked"])
def test_who_dies_costs_its_own_evidence(tmp_path, blamed):
    """Whether the mark tells who it was or not, the others keep their own numbers, in their own places."""
    executor = Fragile(tmp_path, BOTH, blaming(blamed))

    assert errors(executor) == [("", ""), (TWICE, TWICE), ("", "")]
    assert not list(tmp_path.iterdir())


def test_who_is_blamed_wrongly_is_run_by_itself(tmp_path):
    """A scheme that ran when the process died of another has its numbers all the same."""
    first = []

    def blamed(entries):
        first.append(0)
        return (2, NO_MEASURE) if len(first) == 1 else blaming("milstein")(entries)

    assert errors(Fragile(tmp_path, BOTH, blamed)) == [("", ""), (TWICE, TWICE), ("", "")]


def test_workers_that_are_not_isolated():
    """Blocks run over any executor, or over none."""
    with ThreadPoolExecutor(1) as executor:
        assert errors(executor) == [("", "")] * 3
    assert errors(None) == [("", "")] * 3


def test_a_block_is_cut_where_there_are_fewer_than_workers_can_take():
    """Two workers get one block in pieces of a scheme, and four blocks of a look whole: each piece draws noise."""
    task = replace(TASK, settings=Settings(paths=160, block=40, levels=3, coarsest=2))
    for blocks, schemes in {1: [1, 1, 1], 4: [3, 3, 3, 3]}.items():
        with ThreadPoolExecutor(2) as executor:
            jobs = deque(Given(task, block) for block in range(blocks))
            found = [one for _, one in Blocks(Crew(executor, 2), None).results(jobs, 4) if isinstance(one, Portion)]
        assert [len(portion) for portion in found] == schemes


def test_who_takes_too_long_is_not_tried_again(tmp_path):
    """The alarm blames the right one; its reason names the limit."""
    executor = Fragile(tmp_path, BOTH, blaming("milstein"), deadline=100.0)
    late = "no result within 5 s on a block of paths (--timeout)"

    assert errors(executor) == [("", ""), (late, late), ("", "")]
    assert [len(names) for names in executor.parcels] == [6, 4]


def test_a_measure_costs_its_own_evidence(tmp_path):
    """A scheme keeps the evidence of its other measures."""
    executor = Fragile(tmp_path, {("milstein", "weak")}, blaming("milstein", "weak"))

    assert errors(executor) == [("", ""), ("", TWICE), ("", "")]


def test_a_problem_costs_all_its_evidence(tmp_path):
    """Where the problem's own code ran, nobody is tried again."""
    executor = Fragile(tmp_path, BOTH, lambda _: (PROBLEM, NO_MEASURE))

    assert errors(executor) == [(f"problem gbm: {TWICE}",) * 2] * 3
    assert [len(names) for names in executor.parcels] == [6, 6]


def test_a_problem_that_is_killed_once(tmp_path):
    """A process that was killed from elsewhere while the problem's code ran costs nothing: it is tried once more."""
    executor = Fragile(tmp_path, BOTH, lambda _: executor.guilty.clear() or (PROBLEM, NO_MEASURE))
    executor.guilty = set(BOTH)

    assert errors(executor) == [("", "")] * 3
    assert [len(names) for names in executor.parcels] == [6, 6]


def test_a_single_scheme_that_is_killed_once(tmp_path):
    """A scheme that is alone in its parcel is tried once more, too."""
    alone = replace(TASK, entries=TASK.entries[1:2])
    executor = Fragile(tmp_path, BOTH, lambda _: executor.guilty.clear() or (0, NO_MEASURE))
    executor.guilty = set(BOTH)

    *_, (_, (lane,)) = Blocks(executor, None).results(deque([Given(alone, 0)]), 1)

    assert lane.errors == ("", "")
    assert len(executor.parcels) == 2


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (3, "its worker process died with exit code 3"),
        (-9, "its worker process died of SIGKILL, perhaps for want of memory"),
        (-11, "its worker process died of SIGSEGV"),
        (-63, "its worker process died of signal 63"),
        (None, "its worker process died, perhaps for want of memory"),
    ],
)
def test_what_died_is_said(code, words):
    """The reason names the exit code or the signal, as far as they are known."""
    assert Lost(Mark(), False, 5.0, code).why("late") == words
