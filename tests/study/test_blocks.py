"""Blocks over an executor whose workers die: evidence is that of the scheme it is about."""

import pickle
import time
from collections import deque
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import pytest
from pebble import ProcessExpired

from facade import (
    DIED,
    FORMAT,
    NO_MEASURE,
    NOBODY,
    PROBLEM,
    Blocks,
    Entry,
    EulerMaruyama,
    Limits,
    Milstein,
    Processes,
    StochasticTheta,
    Strong,
    Task,
    Weak,
    Workers,
    gbm,
    problem_spec,
    run_block,
)
from sdaeverify import Settings

SETTINGS = Settings(paths=40, block=40, levels=3, coarsest=2)
SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
STRONG, WEAK = Strong(), Weak()
TASK = Task(problem_spec(gbm), tuple(Entry(scheme, (STRONG, WEAK)) for scheme in SCHEMES), SETTINGS)


class Given(NamedTuple):
    """A job."""

    task: Task
    block: int


class Fragile(Processes):
    """Dies where a batch holds a scheme and a measure, with a mark of who is said to have done it."""

    active = True

    def __init__(self, folder, guilty, blamed, deadline=float("inf")):
        super().__init__(1, (), Limits(5.0), folder)
        self.guilty, self.blamed, self.deadline, self.batches = guilty, blamed, deadline, []

    def submit(self, fn, /, *args):
        """Make a call, or die of it or never come back."""
        _, argument, mark, _ = args
        task = pickle.loads(argument)
        names = [(e.scheme.name, m.name) for e in task.entries for m in e.measures]
        self.batches.append(names)
        future = Future()
        if any(pair in names for pair in self.guilty):
            mark.write_bytes(FORMAT.pack(*self.blamed(task.entries), self.deadline))
            if self.deadline > time.monotonic():
                future.set_exception(ProcessExpired("it died", code=-9))
        else:
            future.set_result(pickle.dumps(run_block(task, 0)))
        return future


class Counting(Executor):
    """Notes how many schemes there are in each call."""

    def __init__(self, executor):
        self.executor, self.schemes = executor, []

    def submit(self, fn, /, *args):
        """Make a call."""
        self.schemes.append(len(pickle.loads(args[1]).entries))
        return self.executor.submit(fn, *args)


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
    ((_, evidence),) = Blocks(executor, None).results(deque([Given(TASK, 0)]), 1)
    for found, whole in zip(evidence, run_block(TASK, 0), strict=True):
        for index, error in enumerate(found.errors):
            if not error:
                one, other = found.tallies[index], whole.tallies[index]
                assert {n: v.tolist() for n, v in one.sums.items()} == {n: v.tolist() for n, v in other.sums.items()}
    return [found.errors for found in evidence]


TWICE = f"{DIED} of SIGKILL, perhaps for want of memory, twice"
BOTH = {("milstein", "strong"), ("milstein", "weak")}


def test_nobody_dies(tmp_path):
    """Good schemes are run together, once."""
    executor = Fragile(tmp_path, set(), blaming(""))

    assert errors(executor) == [("", "")] * 3
    assert len(executor.batches) == 1


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
            jobs, counting = deque(Given(task, block) for block in range(blocks)), Counting(executor)
            assert len(list(Blocks(Workers(counting, 2), None).results(jobs, 4))) == blocks
        assert counting.schemes == schemes


def test_who_takes_too_long_is_not_tried_again(tmp_path):
    """The alarm blames the right one; its reason names the limit."""
    executor = Fragile(tmp_path, BOTH, blaming("milstein"), deadline=0.0)
    late = "no result within 5 s on a block of paths (--timeout)"

    assert errors(executor) == [("", ""), (late, late), ("", "")]
    assert [len(names) for names in executor.batches] == [6, 4]


def test_a_measure_costs_its_own_evidence(tmp_path):
    """A scheme keeps the evidence of its other measures."""
    executor = Fragile(tmp_path, {("milstein", "weak")}, blaming("milstein", "weak"))

    assert errors(executor) == [("", ""), ("", TWICE), ("", "")]


def test_a_problem_costs_all_its_evidence(tmp_path):
    """Where the problem's own code ran, nobody is tried again."""
    executor = Fragile(tmp_path, BOTH, lambda _: (PROBLEM, NO_MEASURE))

    assert errors(executor) == [(f"problem gbm: {TWICE}",) * 2] * 3
    assert [len(names) for names in executor.batches] == [6, 6]


def test_a_problem_that_is_killed_once(tmp_path):
    """A process that was killed from elsewhere while the problem's code ran costs nothing: it is tried once more."""
    executor = Fragile(tmp_path, BOTH, lambda _: executor.guilty.clear() or (PROBLEM, NO_MEASURE))
    executor.guilty = set(BOTH)

    assert errors(executor) == [("", "")] * 3
    assert [len(names) for names in executor.batches] == [6, 6]


def test_a_single_scheme_that_is_killed_once(tmp_path):
    """A scheme that is alone in its batch is tried once more, too."""
    alone = replace(TASK, entries=TASK.entries[1:2])
    executor = Fragile(tmp_path, BOTH, lambda _: executor.guilty.clear() or (0, NO_MEASURE))
    executor.guilty = set(BOTH)

    ((_, (found,)),) = Blocks(executor, None).results(deque([Given(alone, 0)]), 1)

    assert found.errors == ("", "")
    assert len(executor.batches) == 2
