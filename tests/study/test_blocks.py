"""Blocks over workers: who dies or takes too long costs its own evidence, and nobody else's numbers."""

import pickle
from collections import deque
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import pytest

from facade import (
    NO_MEASURE,
    PROBLEM,
    Blocks,
    Entry,
    EulerMaruyama,
    Milstein,
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

from .fragile import BOTH, TWICE, blaming

SETTINGS = Settings(paths=40, block=40, levels=3, coarsest=2)
SCHEMES = (EulerMaruyama(), Milstein(), StochasticTheta())
TASK = Task(problem_spec(gbm), tuple(Entry(scheme, (Strong(), Weak())) for scheme in SCHEMES), SETTINGS)
LATE = "no result within 5 s on a block of paths (--timeout)"


class Given(NamedTuple):
    """A job."""

    task: Task
    block: int
    evidence: tuple = ()


class Counting(Executor):
    """Notes how many schemes there are in each call."""

    def __init__(self, executor):
        self.executor, self.schemes = executor, []

    def submit(self, fn, /, *args):
        """Make a call."""
        self.schemes.append(len(pickle.loads(args[1]).entries))
        return self.executor.submit(fn, *args)


def errors(executor, task=TASK):
    """Return what became of the schemes, and check that every good one has its own numbers."""
    (done,) = Blocks(executor, None).results(deque([Given(task, 0)]), 1)
    evidence = done.evidence
    for found, whole in zip(evidence, run_block(task, 0), strict=True):
        for index, error in enumerate(found.errors):
            if not error:
                one, other = found.tallies[index], whole.tallies[index]
                assert {n: v.tolist() for n, v in one.sums.items()} == {n: v.tolist() for n, v in other.sums.items()}
    return [found.errors for found in evidence]


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("guilty", "blamed", "found", "calls"),
    [
        ((), None, [("", "")] * 3, [6]),
        (BOTH, blaming("milstein"), [("", ""), (TWICE, TWICE), ("", "")], [6, 2, 4]),
        (BOTH, blaming("nobody"), [("", ""), (TWICE, TWICE), ("", "")], [6, 2, 2, 2, 2]),
        ({("milstein", "weak")}, blaming("milstein", "weak"), [("", ""), ("", TWICE), ("", "")], [6, 1, 5]),
        (BOTH, lambda _: (PROBLEM, NO_MEASURE), [(f"problem gbm: {TWICE}",) * 2] * 3, [6, 6]),
    ],
    ids=["good", "marked", "unmarked", "measure", "problem"],
)
def test_who_dies_costs_its_own_evidence(fragile, guilty, blamed, found, calls):
    """Whether the mark tells who it was or not, the others keep their own numbers, in their own places."""
    executor = fragile(guilty, blamed)

    assert errors(executor) == found
    assert executor.calls == calls
    assert not executor.marks


def test_who_is_blamed_wrongly_is_run_by_itself(fragile):
    """A scheme that ran when the process died of another has its numbers all the same."""
    first = []

    def blamed(entries):
        first.append(0)
        return (2, NO_MEASURE) if len(first) == 1 else blaming("milstein")(entries)

    assert errors(fragile(BOTH, blamed)) == [("", ""), (TWICE, TWICE), ("", "")]


def test_who_takes_too_long_is_not_tried_again(fragile):
    """The alarm blames the right one; its reason names the limit."""
    executor = fragile(BOTH, blaming("milstein"), deadline=0.0)

    assert errors(executor) == [("", ""), (LATE, LATE), ("", "")]
    assert executor.calls == [6, 4]


@pytest.mark.parametrize(
    ("task", "index"), [(TASK, PROBLEM), (replace(TASK, entries=TASK.entries[1:2]), 0)], ids=["problem", "scheme"]
)
def test_who_is_killed_once_is_asked_again(fragile, task, index):
    """A process that was killed from elsewhere costs nothing, whether the problem's code ran or a lone scheme's."""
    executor = fragile(BOTH, lambda _: executor.guilty.clear() or (index, NO_MEASURE))

    assert errors(executor, task) == [("", "")] * len(task.entries)
    assert len(executor.calls) == 2


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
