"""Runs of experiments: the same numbers for any workers, the same paths for all rows, and what goes wrong."""

from concurrent.futures import ThreadPoolExecutor
from math import isnan

import numpy as np
import pytest

from experiments.euler_errors import mean_square
from sdaeverify import SDE, FineRun, Row
from sdaeverify.contracts.specs import problem_spec
from sdaeverify.lab.experiments.block import BlockTask, run_block
from sdaeverify.lab.experiments.quantity import Quantity, Value
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein


def brownian_motion() -> SDE:
    return SDE(
        drift=lambda t, x: np.zeros_like(x), diffusion=lambda t, x: np.ones((1, 1, 1)),
        diffusion_derivative=lambda t, x, y: np.zeros((1, 1, 1)), start=[0.0], noise_dim=1, horizon=2.0,
        observables={"x": lambda t, s: s["x"][0], "t": lambda t, s: np.full(s["x"].shape[1], t)},
        source="Kloeden & Platen 1992, section 1.7",
    )  # fmt: skip


class Explodes(EulerMaruyama):
    name = "explodes"

    def step(self, problem, state, t, h, noise):
        return super().step(problem, state * 1e30, t, h, noise)


class Raises(EulerMaruyama):
    name = "raises"

    def step(self, problem, state, t, h, noise):
        raise FloatingPointError("no step")


def row(scheme="euler-maruyama", steps=4, problem="gbm[b=0]", observable="x", **other):
    return Row(problem=problem, scheme=scheme, steps=steps, observable=observable, **other)


def final(scheme, steps, observable):
    return Quantity(Value(scheme, steps, observable, steps))


def finished(run, executor=None, window=1):
    events = list(run.run(executor, window))
    assert [event.done for event in events] == list(range(1, run.total + 1))
    return run.samples


def test_closed_form(planned):
    """Without noise, Euler's scheme on x' = x/2 gives (1 + h/2)^n, at every step size and for every observable."""
    ((*samples,),) = finished(planned(row(steps=3), row(steps=12), row(steps=12, observable="x^2")))

    assert [sample.paths for sample in samples] == [10, 10, 10]
    expected = (1 + 1 / 6) ** 3, (1 + 1 / 24) ** 12, (1 + 1 / 24) ** 24
    # Rounding of at most 24 products, each of relative size EPS.
    assert [sample.value for sample in samples] == pytest.approx(expected, rel=24 * np.finfo(float).eps)
    # The paths are equal: what is left is the rounding of their mean.
    assert max(sample.deviation for sample in samples) <= 10 * np.finfo(float).eps


def test_mean_with_noise(planned):
    """With noise, E x_n = (1 + h/2)^n within four standard errors, which are told from those of another step."""
    ((coarse, fine),) = finished(planned(row(steps=1, problem="gbm"), row(steps=64, problem="gbm"), paths=4000))

    assert abs(coarse.value - 1.5) < 4 * coarse.std_error
    assert abs(fine.value - (1 + 1 / 128) ** 64) < 4 * fine.std_error
    assert abs(fine.value - 1.5) > 4 * fine.std_error


def test_workers_change_nothing(planned):
    """Blocks that are run side by side give the same numbers to the last bit."""
    rows = row(problem="gbm"), row(problem="gbm", steps=8), row(problem="ou", scheme="milstein")
    alone = finished(planned(*rows, paths=1600))

    for jobs, window in ((3, 9), (2, 1)):
        with ThreadPoolExecutor(jobs) as executor:
            assert finished(planned(*rows, paths=1600), executor, window) == alone


def test_more_paths_keep_the_first(planned):
    """A longer run begins with the paths of a shorter one."""
    short, long = (planned(row(problem="gbm"), paths=paths) for paths in (500, 1000))
    finished(short)
    events = long.run()
    next(events)

    assert short.samples == long.samples


def test_rows_share_their_paths():
    """W(T) is the same for all numbers of steps and schemes, up to the rounding of its sum."""
    quantities = (
        final(EulerMaruyama(), 3, "x"),
        final(EulerMaruyama(), 96, "x"),
        final(Milstein(), 24, "x"),
    )
    samples = run_block(BlockTask(problem_spec(brownian_motion), quantities, 7, 50), 0, 50)

    assert samples[0].value != 0.0
    # Sums of at most 96 increments of size 1.
    assert [sample.value for sample in samples] == pytest.approx([samples[0].value] * 3, abs=96 * 2e-16 * 3)


def test_faults_cost_their_own_rows():
    """A scheme that raises or loses its paths costs its own rows; a lost path has no value of any observable."""
    quantities = (
        final(Raises(), 4, "x"),
        final(Explodes(), 8, "x"),
        final(Explodes(), 8, "t"),
        final(EulerMaruyama(), 4, "x"),
    )
    raised, lost, timed, right = run_block(BlockTask(problem_spec(brownian_motion), quantities, 7, 50), 0, 50)

    assert raised.error == "scheme raises: FloatingPointError: no step"
    assert lost.lost == timed.lost == 50
    assert isnan(lost.value)
    assert isnan(timed.value)
    assert right.paths == 50
    assert right.lost == 0


def test_means_on_the_way(planned):
    """A mean after n of N steps is that of n steps, at its own time."""
    rows = [row(steps=12, at=at, observable=name) for at in (1, 5, 12) for name in ("x", "x^2")]
    ((*samples,),) = finished(planned(*rows))

    expected = [(1 + 1 / 24) ** (at * power) for at in (1, 5, 12) for power in (1, 2)]
    assert [sample.value for sample in samples] == pytest.approx(expected, rel=24 * np.finfo(float).eps)


def test_time_of_a_mean():
    """An observable is given the time at which its mean is taken."""
    quantities = tuple(Quantity(Value(EulerMaruyama(), 8, "t", at)) for at in (1, 6, 8))
    samples = run_block(BlockTask(problem_spec(brownian_motion), quantities, 7, 5), 0, 5)

    assert [sample.value for sample in samples] == [0.25, 1.5, 2.0]


def test_mean_square_against_a_reference(planned):
    """A row with a reference has the mean square of their difference on the same paths, also on the way."""
    reference = FineRun("euler-maruyama", 32)
    rows = [row(steps=4, problem="gbm[b=0.3]", reference=reference, at=at) for at in (2, 4)]
    ((half, whole),) = finished(planned(*rows, paths=8000))

    assert abs(whole.value - mean_square(0.5, 0.3, 4, 8)) < 4 * whole.std_error
    # Half of the time is that of the equation with a/2 and b/sqrt(2).
    assert abs(half.value - mean_square(0.25, 0.3 / 2**0.5, 2, 8)) < 4 * half.std_error
    # Another refinement is told apart.
    assert abs(whole.value - mean_square(0.5, 0.3, 4, 2)) > 4 * whole.std_error
    assert abs(half.value - mean_square(0.25, 0.3 / 2**0.5, 2, 2)) > 4 * half.std_error


def test_reference_of_another_scheme(planned):
    """A reference may be of another scheme: Milstein's is exact where the noise is 0, and no path differs."""
    same = row(scheme="milstein", reference=FineRun("euler-maruyama", 8))
    ((sample,),) = finished(planned(same))

    assert sample.value == pytest.approx(((1 + 1 / 8) ** 4 - (1 + 1 / 16) ** 8) ** 2, rel=1e-12)


def test_faults_of_a_reference_cost_its_rows():
    """Where the reference raises or loses its paths, so do the rows that are compared with it, and no others."""
    own, raising, losing = (Value(scheme, 8, "x", 8) for scheme in (EulerMaruyama(), Raises(), Explodes()))
    coarse = Value(EulerMaruyama(), 4, "x", 4)
    quantities = Quantity(coarse, own), Quantity(coarse, raising), Quantity(coarse, losing), Quantity(own)
    right, raised, lost, alone = run_block(BlockTask(problem_spec(brownian_motion), quantities, 7, 50), 0, 50)

    assert (right.paths, alone.paths, right.lost, alone.lost) == (50, 50, 0, 0)
    assert raised.error == "scheme raises: FloatingPointError: no step"
    assert lost.lost == 50
    assert isnan(lost.value)


def test_block_size(planned):
    """An experiment says how many paths are simulated together; it is part of what determines them."""
    small, large = (planned(row(problem="gbm"), paths=40, block=block) for block in (20, 40))

    assert (small.plan.sizes, large.plan.sizes) == ((20, 20), (40,))
    assert finished(small) != finished(large)


def test_scheme_that_does_not_match(planned):
    """A scheme that cannot solve the problem says why."""
    ((sample,),) = finished(planned(row(scheme="half-explicit-euler")))

    assert "HolonomicSDAE" in sample.error


def test_unknown_observable(planned):
    """An observable that the problem does not have is an error of the row and not of the program."""
    ((sample, other),) = finished(planned(row(observable="y"), row()))

    assert "no observable 'y'; it has x, x^2, x^3" in sample.error
    assert other.error == ""
