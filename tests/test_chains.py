"""Replicated chains: what is averaged, when it is trusted, and the intervals that come from groups of chains."""

from dataclasses import replace
from itertools import islice
from typing import ClassVar

import numpy as np
import pytest
from scipy.stats import binom, t

from facade import BURN_IN, GROUPS, MOST_FIRST, ChainPlan, ChainRecord, Chains, average_groups, run_chains, run_pilot
from facade import chains_LEVELS as LEVELS
from sdaeverify import Scheme, Step
from sdaeverify.measuring import packed, unpacked
from sdaeverify.studying import Brownian, Source
from stationary_cells import SIGMA, VARIANCE, Euler, double_well, euler_variance, ou, rotation

SMALL = ChainPlan(h=0.25, relaxation_time=1.0, seed=5, looks=3, paired=2 * GROUPS, wide=4 * GROUPS)
SMALL_PILOT = SMALL._replace(wide=8 * GROUPS)


class WithAreas(Euler):
    """Euler-Maruyama that has H drawn beside dW, as `Brownian.steps` does."""

    name: ClassVar[str] = "with-areas"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})


class Exploding(Euler):
    """A step that overflows."""

    name: ClassVar[str] = "exploding"

    def step(self, problem, state, t, h, noise):
        return Step(np.full_like(state, np.inf))


class Failing(Euler):
    """Euler-Maruyama that finds no root on its first path."""

    name: ClassVar[str] = "failing"

    def step(self, problem, state, t, h, noise):
        failed = np.arange(state.shape[1]) == 0
        return super().step(problem, state, t, h, noise)._replace(failed=failed)


def chains(problem=None, h=0.25, paths=GROUPS, levels=1, seed=3):
    return Chains(Euler(), problem or ou(), Source(seed, "test", 0, paths), h, levels)


def never(record):
    return False


def test_time_averages_are_those_of_a_loop():
    """Averages over the coarse grid times equal a hand-written loop over the same noise at two step sizes."""
    h, steps, paths = 0.25, 6, 4
    averages = Chains(WithAreas(), ou(), Source(3, "test", 0, paths), h, 2).average(steps)

    x, sums = np.ones((2, paths)), np.zeros((2, paths))
    for coarse, fine in islice(Brownian(Source(3, "test", 0, paths), 1, h, 1).steps(), steps):
        x[0] += -h * x[0] + SIGMA * coarse.dW[0, 0]
        for half in (0, 1):
            x[1] += -0.5 * h * x[1] + SIGMA * fine.dW[half, 0]
        sums += x**2
    np.testing.assert_allclose(averages[:, 1], sums / steps, rtol=1e-12)


def test_groups_are_means_of_as_many_chains():
    """Group k is the mean of its share of the chains, for each level and observable."""
    values = np.arange(2 * 3 * 2 * GROUPS, dtype=float).reshape(2, 3, 2 * GROUPS)

    groups = average_groups(values)

    assert groups.shape == (GROUPS, 2, 3)
    assert groups[5, 1, 2] == values[1, 2, 10:12].mean()


def test_looks_double_the_record():
    """Each look has twice the record of the last one, and contains it."""
    record = run_chains(Euler(), ou(), SMALL, never)

    np.testing.assert_allclose(record.time, record.time[0] * np.array([1.0, 2.0, 4.0]))
    assert record.levels.shape == (3, GROUPS, LEVELS, 3)
    assert record.wide.shape == (3, GROUPS, 3)
    assert record.burn_in == record.time[0] == BURN_IN
    np.testing.assert_array_equal(record.h, 0.25 / 2.0 ** np.arange(LEVELS))


def test_a_record_that_is_enough_ends_the_run():
    """The first looks are those of a longer run, and the last one is never asked about."""
    asked = []

    def enough(record):
        asked.append(len(record.time))
        return len(record.time) == 2

    record = run_chains(Euler(), ou(), SMALL, enough)
    longer = run_chains(Euler(), ou(), SMALL, lambda record: asked.append(len(record.time)))

    assert asked == [1, 2, 1, 2]
    np.testing.assert_array_equal(record.levels, longer.levels[:2])


def test_records_depend_on_the_seed_alone():
    """The same seed gives the same bits, another one does not, and evidence keeps them."""
    record, same = (run_chains(Euler(), ou(), SMALL._replace(looks=1), never) for _ in range(2))
    other = run_chains(Euler(), ou(), SMALL._replace(looks=1, seed=6), never)

    np.testing.assert_array_equal(record.levels, same.levels)
    assert not np.array_equal(record.levels, other.levels)
    np.testing.assert_array_equal(unpacked("chains", ChainRecord, packed("chains", record)).wide, record.wide)


@pytest.mark.parametrize(("relaxation", "looks"), [(1.0, 6), (10.0, 2), (1000.0, 1)])
def test_plans_keep_to_what_is_affordable(relaxation, looks):
    """There are as many looks as the steps allow, and always one."""
    plan = ChainPlan(h=0.25, relaxation_time=relaxation, seed=1).affordable
    steps = plan.steps(BURN_IN)

    assert plan.looks == looks
    assert looks == 1 or plan.affords(steps + steps * 2 ** (looks - 1))
    assert looks == 6 or not plan.affords(steps + steps * 2**looks)


def test_step_sizes_that_blow_up_are_halved():
    """A drift -50 x allows Euler steps below 2/50: the first such halving is used, and the last that failed kept."""
    stiff = replace(ou(start=[0.1]), drift=lambda t, x: -50.0 * x)

    record = run_chains(Euler(), stiff, SMALL._replace(looks=1), never)

    assert record.diverged == 0.0625
    assert record.h[0] == 0.03125
    assert not record.lost.any()


def test_what_is_never_stable_has_no_looks():
    """A drift +x has no stable step size: nothing is recorded, and the chains are counted as lost."""
    unstable = replace(ou(), drift=lambda t, x: 5.0 * x)

    record = run_chains(Euler(), unstable, SMALL, never)

    assert len(record.time) == 0
    assert (record.lost == SMALL.wide).all()


def test_nothing_is_recorded_where_steps_fail():
    """Paths without root at the finest levels leave no order to be seen: no time is spent on them."""
    record = run_chains(Failing(), ou(), SMALL, never)

    assert len(record.time) == 0
    assert (record.failed > 0).all()
    assert not record.lost.any()


def test_records_tell_whether_they_are_stationary():
    """From a far start the record moves; ten relaxation times later it does not."""
    run = chains(ou(start=[10.0]), paths=20 * GROUPS)

    assert not run.record(40)[1]
    assert run.record(40)[1]


@pytest.mark.slow
def test_burn_in_outlasts_a_relaxation_time_that_is_too_short():
    """From a far start with a declared relaxation time 20 times too short, the burn-in is doubled until it is not."""
    plan = SMALL._replace(h=0.0125, relaxation_time=0.05, looks=1, paired=20 * GROUPS)

    record = run_chains(Euler(), ou(start=[10.0]), plan, never)

    assert record.stationary == 1.0
    assert record.burn_in >= 4.0 * BURN_IN * plan.relaxation_time
    assert abs(record.levels[0, :, :, 0].mean()) < 0.1


@pytest.mark.slow
def test_what_never_settles_is_not_called_stationary():
    """Without friction the second moment grows for ever."""
    plan = SMALL._replace(paired=20 * GROUPS, wide=20 * GROUPS)
    record = run_chains(Euler(), replace(ou(), drift=lambda t, x: 0.0 * x), plan, never)

    assert record.stationary == 0.0


def test_contraction_is_recognised():
    """Two chains with the same noise meet under friction, and keep their distance on the circle."""
    contracting, not_contracting = (run_pilot(Euler(), problem, SMALL_PILOT) for problem in (ou(), rotation()))

    assert contracting.contraction < 1e-4
    assert not_contracting.contraction == pytest.approx(1.0, abs=0.2)


def test_full_turns_are_no_distance():
    """Chains of an angle that settle in different turns have met: distances are those of the observables."""
    tilted = replace(rotation(), drift=lambda t, x: -3.0 * np.sin(x))

    assert run_pilot(Euler(), tilted, SMALL_PILOT._replace(h=0.125, relaxation_time=4.0)).contraction < 1e-3


def coverage(problem, observable, exact, repetitions):
    """Return how often 95 % intervals from 16 chains of 1000 steps contain a stationary mean at h = 0.1."""
    run = chains(problem, 0.1, 16 * repetitions)
    run.advance(int(100.0 * problem.relaxation_time))
    means = run.average(1000)[0, list(problem.observables).index(observable)].reshape(repetitions, 16)
    half = t.ppf(0.975, 15) * means.std(axis=1, ddof=1) / 4.0
    return float(np.mean(np.abs(means.mean(axis=1) - exact) <= half))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("problem", "observable", "exact"),
    [(ou(), "x^2", euler_variance(0.1)), (double_well(), "x", 0.0)],
    ids=["ou x^2", "double well x"],
)
def test_intervals_of_replicated_chains_cover(problem, observable, exact, capsys):
    """Nominal 95 % intervals from 16 chains of 1000 steps cover what 2000 repetitions allow at a level of 1e-4."""
    repetitions = 2000
    rate = coverage(problem, observable, exact, repetitions)

    with capsys.disabled():
        print(f"\ncoverage of {observable}: {rate:.3f}")
    assert binom.ppf(1e-4, repetitions, 0.95) <= repetitions * rate <= binom.ppf(1 - 1e-4, repetitions, 0.95)


@pytest.mark.slow
def test_pairing_gains_like_one_over_h_squared(capsys):
    """The variance of mean differences, independent over paired, grows like h^-2."""
    run = chains(h=0.2, paths=4000, levels=5)
    run.advance(50)
    means = run.average(100)[:, 1]

    gain = (means[:-1].var(axis=-1) + means[1:].var(axis=-1)) / (means[:-1] - means[1:]).var(axis=-1)

    with capsys.disabled():
        print(f"\ngain by pairing at h = .2 .1 .05 .025: {' '.join(f'{value:.0f}' for value in gain)}")
    assert np.polyfit(np.arange(4.0), np.log2(gain), 1)[0] == pytest.approx(2.0, abs=0.2)
    assert (gain > np.array([150.0, 600.0, 2400.0, 9600.0])).all()


@pytest.mark.slow
def test_stationary_means_are_those_of_the_scheme():
    """On all levels the stationary variance of Euler-Maruyama is sigma^2/(2 - h), within four standard errors."""
    record = run_chains(Euler(), ou(), ChainPlan(h=0.25, relaxation_time=1.0, seed=8, looks=3), never)
    means = record.levels[-1, :, :, 1]

    error = (means.mean(axis=0) - euler_variance(record.h)) / (means.std(axis=0, ddof=1) / np.sqrt(GROUPS))

    assert np.abs(error).max() < 4.0
    assert record.levels[-1, :, 0, 1].mean() > VARIANCE * 1.1


def test_a_plan_whose_first_look_is_too_long_makes_no_step():
    """Neither a pilot run nor chains: a record without looks comes back at once, of the size that was asked for."""
    plan = ChainPlan(h=0.1155, relaxation_time=104.0, seed=8)
    assert plan.first_look > MOST_FIRST

    record = run_chains(Scheme(), ou(), plan, never)

    assert len(record.time) == 0
    assert record.h[0] == plan.h
    assert not record.lost.any()


def test_step_sizes_are_halved_as_long_as_chains_can_begin():
    """Where every size blows up, the last one tried is the last whose burn-in and first record can be afforded."""
    plan = ChainPlan(h=0.25, relaxation_time=8.0, seed=8, paired=GROUPS, wide=GROUPS)

    record = run_chains(Exploding(), ou(), plan, never)

    assert record.lost.all()
    smallest = plan._replace(h=float(record.diverged))
    assert smallest.first_look <= MOST_FIRST < smallest._replace(h=0.5 * smallest.h).first_look


def test_the_base_scheme_is_no_scheme():
    """Chains of a scheme without a step say so at once."""
    with pytest.raises(NotImplementedError):
        Chains(Scheme(), ou(), Source(3, "test", 0, 4), 0.25).advance(1)
