"""The time loop: shared noise, isolation of what goes wrong, counts that lose nothing."""

from dataclasses import dataclass, replace
from itertools import count
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    Drift,
    DriftTruncatedEuler,
    Entry,
    EulerMaruyama,
    HalfExplicitEuler,
    Milstein,
    MilsteinAreas,
    Strong,
    Task,
    Track,
    Weak,
    gbm,
    levy_area,
    ou,
    pendulum,
    problem_spec,
    run_block,
)
from sdaeverify import SDE, Scheme, Settings, Step
from sdaeverify.probe.step.times import ROW
from sdaeverify.simulate.reference import OWN_REFERENCE

STRONG = Strong()
SETTINGS = Settings(paths=120, levels=4, block=60)
# In the first block a scheme that breaks its contract is not run; later ones notice what goes wrong on the way.
LATER = 1


@dataclass(frozen=True)
class Odd(Scheme):
    """Euler-Maruyama that does something odd from the middle of the interval on."""

    what: str = "nothing"

    name: ClassVar[str] = "odd"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        new = EulerMaruyama().step(problem, state, t, h, noise).state
        first = np.arange(new.shape[1]) == 0
        if t < 0.5 * problem.horizon:
            return Step(new)
        return {
            "nothing": lambda: Step(new),
            "nan": lambda: Step(np.where(first, np.nan, new)),
            "huge": lambda: Step(np.where(first, 1e12, new)),
            "no root": lambda: Step(new, failed=first),
            "truncated": lambda: Step(new, truncated=first),
            "raise": lambda: Step(new / {}["missing"]),
        }[self.what]()


class Rude(Scheme):
    """A scheme that drops all paths but one."""

    name: ClassVar[str] = "rude"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        return Step(state[:, :1])


def lanes(family, schemes, settings=SETTINGS, measures=(STRONG,), block=0):
    return run_block(Task(problem_spec(family), tuple(Entry(s, measures) for s in schemes), settings), block)


def assert_same_evidence(a, b):
    for one, other in zip(a.tallies, b.tallies, strict=True):
        for kind in ("sums", "maxima", "largest"):
            left, right = getattr(one, kind), getattr(other, kind)
            assert left.keys() == right.keys()
            assert all(np.array_equal(left[name], right[name], equal_nan=True) for name in left)


@pytest.mark.parametrize("family", [gbm, ou, pendulum])
def test_evidence_on_a_scheme_does_not_depend_on_the_others(family):
    """A scheme alone and among others gives the same bits."""
    alone = lanes(family, [EulerMaruyama()])[0]

    among = lanes(family, [DriftTruncatedEuler(), EulerMaruyama()])[1]

    assert_same_evidence(alone, among)


def test_a_finer_level_leaves_coarser_ones_as_they_were():
    """Adding a level changes no error against an exact solution at the levels there were."""
    few = lanes(gbm, [Milstein()])[0].tallies[0].sums["error x"]

    more = lanes(gbm, [Milstein()], Settings(paths=120, levels=5, block=60))[0].tallies[0].sums["error x"]

    assert np.array_equal(few, more[:, :4])


def test_blocks_are_independent_samples():
    """Two blocks of one run see different noise."""
    settings = Settings(paths=120, levels=4, block=60)

    first, second = (lanes(gbm, [EulerMaruyama()], settings, block=block)[0] for block in range(2))

    assert not np.any(first.tallies[0].sums["error x"] == second.tallies[0].sums["error x"])


STEPS = np.array(SETTINGS.steps)
COUNTS = {
    "nan": {"lost": 1, "failed": 1},
    "huge": {"lost": 1, "failed": 1},
    "no root": {"lost": 0, "failed": 1},
    "truncated": {"truncated": STEPS / 2, "steps": 60 * STEPS},
}


@pytest.mark.parametrize("what", COUNTS)
def test_what_goes_wrong_is_counted(what):
    """Paths that are not finite, blow up or find no root count once at each level, truncated steps each."""
    health = lanes(gbm, [Odd(what)], block=LATER)[0].health.sums

    assert all((health[name] == count).all() for name, count in COUNTS[what].items())


def test_a_nan_stays_in_the_sums():
    """The group of a lost path has no finite sum: nothing was dropped."""
    sums = lanes(gbm, [Odd("nan")], block=LATER)[0].tallies[0].sums["error x"]

    assert np.isnan(sums[0]).all()
    assert np.isfinite(sums[1:]).all()


def test_a_scheme_that_raises_costs_its_own_lane():
    """What a scheme raises is the reason of its own evidence; others go on."""
    broken, fine = lanes(gbm, [Odd("raise"), EulerMaruyama()], block=LATER)

    assert broken.errors[0].startswith("KeyError: 'missing' (")
    assert not fine.errors[0]
    assert_same_evidence(fine, lanes(gbm, [EulerMaruyama()], block=LATER)[0])


def test_a_scheme_that_breaks_its_contract_is_not_run():
    """It is told before anything is measured."""
    lane = lanes(gbm, [Rude()])[0]

    assert "expected a state like the one it was given" in lane.violation
    assert lane.paths == 0


def test_a_truth_that_raises_costs_the_problem():
    """What a problem raises while it runs is the reason of all its lanes."""

    def fickle() -> SDE:
        problem = gbm()
        return replace(
            problem, diffusion=lambda t, x: problem.diffusion(t, x) if t == 0.0 else {}["gone"], controls=()
        )

    (lane,) = lanes(fickle, [EulerMaruyama()], block=LATER)

    assert "KeyError: 'gone'" in lane.errors[0]


def no_truth() -> SDE:
    """Return geometric Brownian motion of which nothing is known."""
    return replace(gbm(), truths=(), controls=())


@pytest.mark.parametrize("family", [no_truth, pendulum])
def test_who_compares_with_no_truth_makes_no_steps_for_one(family, monkeypatch):
    """Where nobody asks for the truth no noise is finer than the finest level, and what is noted is the same."""
    measure = Weak() if family is no_truth else Drift()
    scheme = EulerMaruyama() if family is no_truth else HalfExplicitEuler("none")
    drawn = []
    advance = Track.advance
    monkeypatch.setattr(Track, "advance", lambda self, *given: drawn.append(self.level) or advance(self, *given))
    (both,) = lanes(family, [scheme], measures=(STRONG, measure))
    finest, drawn[:] = max(drawn), []
    (alone,) = lanes(family, [scheme], measures=(measure,))

    assert max(drawn) == SETTINGS.levels - 1
    assert finest == SETTINGS.levels - 1 + (OWN_REFERENCE if family is no_truth else 0)
    assert_same_evidence(alone, both._replace(tallies=both.tallies[1:]))


def test_areas_are_those_of_the_finest_level_whoever_asks():
    """Levy areas are put together from the finest level: they do not depend on whether the truth is asked for."""

    def no_path_known() -> SDE:
        known = levy_area()
        return replace(known, truths=tuple(truth for truth in known.truths if truth is not known.pathwise))

    (both,) = lanes(no_path_known, [MilsteinAreas()], measures=(STRONG, Weak()))
    (alone,) = lanes(no_path_known, [MilsteinAreas()], measures=(Weak(),))

    assert_same_evidence(alone, both._replace(tallies=both.tallies[1:]))


def test_own_reference_is_used_where_there_is_no_truth():
    """Without a pathwise truth a scheme is compared with itself, three levels finer, on the same noise."""
    (lane,) = lanes(no_truth, [EulerMaruyama()])

    errors = lane.tallies[0].sums["error x"][..., 1].sum(axis=0)
    assert (np.diff(errors) < 0.0).all()
    assert len(lane.health.sums["failed"]) == SETTINGS.levels


class Moody(Scheme):
    """A scheme whose steps depend on how often it was asked."""

    name: ClassVar[str] = "moody"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        return Step(state + np.random.default_rng().normal(size=state.shape))


def test_a_scheme_with_hidden_state_is_told():
    """A step that gives something else when it is repeated is no function of its arguments."""
    assert "must depend only on its arguments" in lanes(gbm, [Moody()])[0].violation
    assert "depends on hidden state" in lanes(gbm, [Moody()], block=LATER)[0].errors[0]


class Tiring(EulerMaruyama):
    """A scheme that is off by a rounding error from some call of a prepared step on."""

    name: ClassVar[str] = "tiring"

    def prepare(self, problem, h):
        step, calls = super().prepare(problem, h), count()
        return lambda state, t, noise: Step(step(state, t, noise).state * (1.0 + 1e-15 * (next(calls) >= 40)))


def test_a_step_that_counts_its_calls_is_told_after_the_run():
    """The first step of a run is made once more when the run has ended: it leads where it led."""
    assert "depends on hidden state" in lanes(gbm, [Tiring()])[0].errors[0]
    assert not lanes(gbm, [EulerMaruyama()])[0].errors[0]


class Clumsy(Strong):
    """A measure that fails while it notes."""

    name = "clumsy"

    def observer(self, problem, parts, settings):
        return None if settings is None else {}["missing"]


def test_a_measure_that_raises_costs_only_its_own_cells():
    """What one measure raises leaves the others' evidence as it is."""
    (lane,) = lanes(gbm, [EulerMaruyama()], measures=(Clumsy(), STRONG))

    assert lane.errors[0].startswith("measure clumsy: KeyError: 'missing' (")
    assert lane.errors[1:] == ("",)
    assert np.array_equal(
        lane.tallies[1].sums["error x"], lanes(gbm, [EulerMaruyama()])[0].tallies[0].sums["error x"]
    )


class Counting(Scheme):
    """Euler-Maruyama that says what it took."""

    name: ClassVar[str] = "counting"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        return Step(
            EulerMaruyama().step(problem, state, t, h, noise).state, costs={"work": np.full(state.shape[1], 2)}
        )


def test_costs_are_summed_over_steps_and_paths():
    """What steps take is counted at every level."""
    health = lanes(gbm, [Counting()])[0].health.sums

    assert (health["cost work"] == 2 * health["steps"]).all()


def test_memory_that_is_no_component_is_kept_apart():
    """A scheme with further memory says which parts of its state can be compared."""

    class Remembering(Scheme):
        """Euler-Maruyama that remembers its last state."""

        name: ClassVar[str] = "remembering"
        form: ClassVar[type[SDE]] = SDE

        def start(self, problem, paths, h):
            return np.concatenate([problem.initial(paths)] * 2)

        def parts(self, problem, state):
            return problem.parts(state[:1])

        def step(self, problem, state, t, h, noise):
            return Step(np.concatenate([EulerMaruyama().step(problem, state[:1], t, h, noise).state, state[:1]]))

    remembering, plain = lanes(gbm, [Remembering(), EulerMaruyama()])

    assert_same_evidence(remembering, plain)


CALLS: list[int] = []


class Counted(EulerMaruyama):
    """A scheme that notes on how many paths each of its steps is made."""

    name: ClassVar[str] = "counted"

    def prepare(self, problem, h):
        step = super().prepare(problem, h)

        def noted(state, t, noise):
            CALLS.append(state.shape[1])
            return step(state, t, noise)

        return noted


def test_probes_make_few_calls_beside_the_steps_of_the_runs():
    """A study of two measures makes no more calls of its probes than a row of steps is long, three times."""
    CALLS.clear()
    lanes(gbm, [Counted()], measures=(STRONG, Weak()))
    steps = SETTINGS.coarsest * (2**SETTINGS.levels - 1) + SETTINGS.levels

    assert steps < len(CALLS) < steps + 3 * ROW
