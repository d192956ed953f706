"""Digests of what schemes and problems do: blind to rounding, and to nothing else."""

from dataclasses import dataclass, replace
from itertools import count
from typing import ClassVar

import numpy as np
import pytest

from evidence import lanes_in
from facade import (
    Behaviour,
    CellEvidence,
    Entry,
    EulerMaruyama,
    HalfExplicitEuler,
    Marker,
    StochasticTheta,
    Store,
    Strong,
    Task,
    behaviours,
    delay_test,
    differing,
    gbm,
    pendulum,
    problem_digest,
    problem_spec,
    run_observed,
    simulate_block,
    steps_digest,
)
from sdaeverify import Settings, Step

NUMBERS = (8, 16, 32)
SETTINGS = Settings(paths=40, block=40, levels=3)
CALLS = count()


@dataclass(frozen=True)
class Scaled(EulerMaruyama):
    """Euler-Maruyama times a factor where something holds."""

    name: ClassVar[str] = "scaled"
    factor: float = 1.0
    since: float = 0.0
    beyond: float = -np.inf
    shorter: float = np.inf

    def step(self, problem, state, t, h, noise):
        """Make the step."""
        new = super().step(problem, state, t, h, noise).state
        here = (state > self.beyond) & (t >= self.since) & (h < self.shorter)
        return Step(np.where(here, self.factor * new, new))


class Turning(EulerMaruyama):
    """Euler-Maruyama that does something else from its fortieth step on."""

    name: ClassVar[str] = "turning"

    def step(self, problem, state, t, h, noise):
        """Make the step."""
        new = super().step(problem, state, t, h, noise).state
        return Step(new if next(CALLS) < 40 else 1.001 * new)


def digest(scheme, problem=None):
    """Return the digest of a scheme on gbm."""
    return steps_digest(scheme, problem or gbm(), NUMBERS)


def test_rounding_does_not_count():
    """Results that differ in their last digits, as those of another machine, have the same digest."""
    assert digest(Scaled(factor=1.0 + 4e-16)) == digest(Scaled()) == digest(EulerMaruyama())


@pytest.mark.parametrize(
    "where",
    [{}, {"since": 0.9}, {"since": 1.5}, {"beyond": 1.2}, {"shorter": 0.04}, {"shorter": 0.001}],
    ids=["everywhere", "late", "after the end", "far out", "finest level", "shorter than any level"],
)
def test_small_changes_count(where):
    """A change in the eighth digit counts, wherever it is."""
    assert digest(Scaled(factor=1.0 + 1e-7, **where)) != digest(Scaled())


@pytest.mark.parametrize(
    ("scheme", "family", "other"),
    [
        (StochasticTheta(), delay_test, {"set": "II"}),
        (StochasticTheta(), delay_test, {"horizon": "3.5"}),
        (HalfExplicitEuler(), pendulum, {"c_g": "0"}),
    ],
)
def test_every_form(scheme, family, other):
    """Digests of delay equations and of constrained ones are the same twice, and tell parameters apart."""
    one, same, another = (
        behaviours(Task(problem_spec(family, texts), (Entry(scheme, ()),), SETTINGS)) for texts in ({}, {}, other)
    )

    assert one == same
    assert one[0].scheme != another[0].scheme
    assert one[0].problem != another[0].problem


def test_what_is_told_of_a_problem():
    """A drift that is wrong late, or for one component far out, is another problem."""
    problem = gbm()
    late = replace(problem, drift=lambda t, x: problem.drift(t, x) + (t > 0.9))

    assert problem_digest(replace(problem)) == problem_digest(problem)
    assert problem_digest(late) != problem_digest(problem)
    assert problem_digest(replace(problem, traits=frozenset())) != problem_digest(problem)


@pytest.mark.parametrize("factor", [2.0, 0.5, 1024.0, -1.0])
def test_a_power_of_two_is_another_number(factor):
    """What is all twice as large is not the same, though its digits are."""
    problem = gbm()
    twice = {name: lambda t, parts, f=f: factor * f(t, parts) for name, f in problem.observables.items()}

    assert problem_digest(replace(problem, observables=twice)) != problem_digest(problem)


def test_a_step_that_raises_has_a_digest():
    """Where the fixed arguments are none for a scheme, what it raises is what it does."""

    class Late(EulerMaruyama):
        def step(self, problem, state, t, h, noise):
            if t > 0.5:
                raise ZeroDivisionError
            return super().step(problem, state, t, h, noise)

    assert digest(Late()) == digest(Late()) != digest(EulerMaruyama())


@pytest.mark.long
def test_what_changes_during_a_run_is_no_evidence(tmp_path):
    """A scheme that does something else at the end of a block than at its begin has no evidence, on disk neither."""
    # The first block is tried for its contract, which this scheme breaks.
    schemes, settings = (Turning(), EulerMaruyama()), replace(SETTINGS, paths=80)
    task = Task(problem_spec(gbm), tuple(Entry(scheme, (Strong(),)) for scheme in schemes), settings)
    places = {recalled.entry.scheme.label: recalled.place for recalled in Store(tmp_path).recall(task, 1)}

    turned, right = simulate_block(task, Marker(), 1, places)

    assert "the same step gave another result when it was repeated" in turned.errors[0]
    assert right.errors == ("",)
    assert [lane.scheme for _, _, lane in lanes_in(tmp_path)] == ["euler-maruyama"]


def test_blocks_of_two_versions_do_not_go_together():
    """Evidence of one block is not added to that of another in which something else was done."""
    task = Task(problem_spec(gbm), (Entry(EulerMaruyama(), (Strong(),)),), replace(SETTINGS, paths=80))
    (first,), (second,) = (run_observed(task, block) for block in range(2))
    other = second._replace(behaviour=Behaviour("something", second.behaviour.problem))

    known = CellEvidence().merge(first, 0)

    assert known.merge(second, 0).error == ""
    assert known.merge(other, 0).error.startswith("the behaviour of the scheme has changed during the run")
    assert differing(None, second.behaviour) == ""


def test_what_digests_cost():
    """Before and after a block a scheme makes no more than nine steps on sixteen paths: little beside the block."""
    steps = []

    class Counting(EulerMaruyama):
        def step(self, problem, state, t, h, noise):
            steps.append(state.shape[-1])
            return super().step(problem, state, t, h, noise)

    settings = Settings()
    steps_digest(Counting(), gbm(), settings.steps)
    digests, block = 2 * sum(steps), sum(settings.steps) * settings.sizes[0]

    assert (len(steps), set(steps)) == (9, {16})
    assert digests < 0.003 * block
