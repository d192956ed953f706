"""Runs of experiments: the same numbers for any workers, the same paths for all rows, and what goes wrong."""

from concurrent.futures import ThreadPoolExecutor
from math import isnan

import numpy as np
import pytest

from experiments.running import lines_of, mean_square
from facade import EulerMaruyama, FineRun, Milstein, Note, Row, SchemeRun, SharedNoise, problem_spec
from sdaeverify import SDE
from sdaeverify_lab.papers.block import NoiseTask, PlannedRun, ProbeTask, run_block, run_probe


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


class Counting(EulerMaruyama):
    name = "counting"

    def step(self, problem, state, t, h, noise):
        return super().step(problem, state, t, h, noise)._replace(costs={"evaluations": np.full(state.shape[1], 2.0)})


def raising(problem, t, parts):
    raise ValueError("not this one")


def position(problem, t, parts):
    return parts["x"]


def first_of(increments):
    return increments[:, :1]


def sum_of(increments):
    return increments.sum(axis=1, keepdims=True) / 3**0.5


def count_things(problems, schemes):
    if not problems:
        raise ValueError("nothing")
    return {"of": [len(problems), len(schemes)]}


def row(scheme="euler-maruyama", steps=4, problem="gbm[b=0]", observable="x", **other):
    return Row(problem=problem, scheme=scheme, steps=steps, observable=observable, **other)


ONLY = (Note("x", "x"),)


def block_of(*schemes, paths=50, problem=brownian_motion, notes=ONLY, steps=8, **other):
    runs = [
        PlannedRun(
            SchemeRun(problem="p", scheme="s", steps=each, notes=notes, **other), problem_spec(problem), scheme
        )
        for scheme, each in zip(schemes, steps if isinstance(steps, tuple) else (steps,) * len(schemes), strict=True)
    ]
    return run_block(NoiseTask(tuple(runs), other.get("noise"), 7, 50), 0, paths)


def finished(run, executor=None, window=1):
    events = list(run.run(executor, window))
    assert [event.done for event in events] == list(range(1, run.total + 1))
    return [line.sample for line in lines_of(run)]


def test_closed_form(planned):
    """Without noise, Euler's scheme on x' = x/2 gives (1 + h/2)^n, at every step size and for every observable."""
    samples = finished(planned(row(steps=3), row(steps=12), row(steps=12, observable="x^2")))

    assert [sample.paths for sample in samples] == [10, 10, 10]
    expected = (1 + 1 / 6) ** 3, (1 + 1 / 24) ** 12, (1 + 1 / 24) ** 24
    # Rounding of at most 24 products, each of relative size EPS.
    assert [sample.value for sample in samples] == pytest.approx(expected, rel=24 * np.finfo(float).eps)
    # The paths are equal: what is left is the rounding of their mean.
    assert max(sample.deviation for sample in samples) <= 10 * np.finfo(float).eps


def test_mean_with_noise(planned):
    """With noise, E x_n = (1 + h/2)^n within four standard errors, which are told from those of another step."""
    coarse, fine = finished(planned(row(steps=1, problem="gbm"), row(steps=64, problem="gbm"), paths=4000))

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

    assert lines_of(short) == lines_of(long)


def test_runs_share_their_paths():
    """W(T) is the same for all numbers of steps and schemes, up to the rounding of its sum."""
    found = block_of(EulerMaruyama(), EulerMaruyama(), Milstein(), steps=(3, 96, 24))
    first, *others = (each.noted["x"].last for each in found)

    assert first[0] != first[1]
    for other in others:
        # Sums of at most 96 increments of size 1.
        assert other == pytest.approx(first, abs=96 * 2e-16 * 3)


def test_faults_cost_their_own_runs():
    """A scheme that raises or loses its paths costs its own run; a lost path has no value of any observable."""
    notes = (Note("x", "x"), Note("t", "t"))
    raised, lost, right = block_of(Raises(), Explodes(), EulerMaruyama(), steps=(4, 8, 4), notes=notes)

    assert raised.error.startswith("scheme raises: FloatingPointError: no step (")
    for name in ("x", "t"):
        assert lost.noted[name].lost.sum() == 50
        assert np.isnan(lost.noted[name].last).all()
        assert np.isfinite(right.noted[name].last).all()
    assert (right.paths, right.noted["x"].lost.sum()) == (50, 0)


def test_faults_of_a_note_cost_that_note():
    """A function that raises, and an observable that is not there, leave the other notes of a run alone."""
    notes = (Note("wrong", raising), Note("missing", "y"), Note("x", "x"))
    (found,) = block_of(EulerMaruyama(), notes=notes)

    assert found.error == found.noted["x"].error == ""
    assert found.noted["wrong"].error.startswith("ValueError: not this one (")
    assert "no observable 'y'; it has x, t" in found.noted["missing"].error


def test_notes_put_together():
    """The mean and the largest of what is noted are those of all steps asked for, each path by itself."""
    at = (2, 3, 7)
    notes = (Note("each", position, at), Note("mean", position, at, "mean"), Note("max", position, at, "max"))
    (found,) = block_of(EulerMaruyama(), notes=notes, paths=5)

    each = found.noted["each"].values
    assert each.shape == (3, 1, 5)
    assert found.noted["each"].at == at
    assert np.array_equal(found.noted["mean"].values, (each[0] + each[1] + each[2])[None] / 3)
    assert np.array_equal(found.noted["max"].values, each.max(axis=0)[None])
    assert found.noted["max"].at == (7,)


def test_counted_costs():
    """What a scheme counts is summed over the steps and paths of each block, with their number."""
    (found,) = block_of(Counting(), paths=5)

    assert found.costs["evaluations"].tolist() == [[2.0 * 8 * 5, 8 * 5]]


def test_noise_shared_by_problems():
    """Problems of different dimension can be driven by one noise, through a map of its increments."""
    noise = SharedNoise("common", 3)
    first, second = (
        block_of(EulerMaruyama(), Milstein(), steps=(4, 16), noise=noise, drive=drive) for drive in (first_of, sum_of)
    )
    (own,) = block_of(EulerMaruyama(), steps=4)

    for found in (first, second):
        assert found[0].noted["x"].last == pytest.approx(found[1].noted["x"].last, abs=1e-13)
    # Two sums of different independent increments, and a noise of another name.
    assert not np.allclose(first[0].noted["x"].last, second[0].noted["x"].last)
    assert not np.allclose(first[0].noted["x"].last, own.noted["x"].last)


def test_noise_of_the_wrong_dimension():
    """Runs on one noise whose problems ask for another number of Brownian motions say so."""
    (found,) = block_of(EulerMaruyama(), noise=SharedNoise("common", 3))

    assert found.error


def test_probe():
    """A probe is given what its labels name; what it raises is its reason."""
    task = ProbeTask(count_things, (problem_spec(brownian_motion),), (Milstein(), EulerMaruyama()), "mine")

    assert {name: values.tolist() for name, values in run_probe(task).values.items()} == {"of": [1, 2]}
    assert run_probe(ProbeTask(count_things, (), (), "mine")).error.startswith("ValueError: nothing (")


def test_means_on_the_way(planned):
    """A mean after n of N steps is that of n steps, at its own time."""
    rows = [row(steps=12, at=at, observable=name) for at in (1, 5, 12) for name in ("x", "x^2")]
    samples = finished(planned(*rows))

    expected = [(1 + 1 / 24) ** (at * power) for at in (1, 5, 12) for power in (1, 2)]
    assert [sample.value for sample in samples] == pytest.approx(expected, rel=24 * np.finfo(float).eps)


def test_time_of_a_note():
    """An observable is given the time at which it is noted."""
    (found,) = block_of(EulerMaruyama(), notes=(Note("t", "t", (1, 6, 8)),), paths=1)

    assert found.noted["t"].values[:, 0].tolist() == [0.25, 1.5, 2.0]


def test_mean_square_against_a_reference(planned):
    """A row with a reference has the mean square of their difference on the same paths, also on the way."""
    reference = FineRun("euler-maruyama", 32)
    rows = [row(steps=4, problem="gbm[b=0.3]", reference=reference, at=at) for at in (2, 4)]
    half, whole = finished(planned(*rows, paths=8000))

    assert abs(whole.value - mean_square(0.5, 0.3, 4, 8)) < 4 * whole.std_error
    # Half of the time is that of the equation with a/2 and b/sqrt(2).
    assert abs(half.value - mean_square(0.25, 0.3 / 2**0.5, 2, 8)) < 4 * half.std_error
    # Another refinement is told apart.
    assert abs(whole.value - mean_square(0.5, 0.3, 4, 2)) > 4 * whole.std_error
    assert abs(half.value - mean_square(0.25, 0.3 / 2**0.5, 2, 2)) > 4 * half.std_error


def test_reference_of_another_scheme(planned):
    """A reference may be of another scheme: Milstein's is exact where the noise is 0, and no path differs."""
    same = row(scheme="milstein", reference=FineRun("euler-maruyama", 8))
    (sample,) = finished(planned(same))

    assert sample.value == pytest.approx(((1 + 1 / 8) ** 4 - (1 + 1 / 16) ** 8) ** 2, rel=1e-12)


def test_faults_of_a_reference_cost_its_rows(planned):
    """Where the reference does not match, so do the rows that are compared with it, and no others."""
    wrong = row(scheme="euler-maruyama", reference=FineRun("half-explicit-euler", 8))
    right = row(scheme="euler-maruyama", reference=FineRun("milstein", 8))
    found = finished(planned(wrong, right))

    assert "HolonomicSDAE" in found[0].error
    assert isnan(found[0].value)
    assert (found[1].error, found[1].paths) == ("", 10)


def test_block_size(planned):
    """An experiment says how many paths are simulated together; it is part of what determines them."""
    small, large = (planned(row(problem="gbm"), paths=40, block=block) for block in (20, 40))

    assert (small.plan.sizes, large.plan.sizes) == ((20, 20), (40,))
    assert finished(small) != finished(large)


def test_scheme_that_does_not_match(planned):
    """A scheme that cannot solve the problem says why."""
    (sample,) = finished(planned(row(scheme="half-explicit-euler")))

    assert "HolonomicSDAE" in sample.error


def test_unknown_observable(planned):
    """An observable that the problem does not have is an error of the row and not of the program."""
    sample, other = finished(planned(row(observable="y"), row()))

    assert "no observable 'y'; it has x, x^2, x^3" in sample.error
    assert other.error == ""
