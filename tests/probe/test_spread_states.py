"""Orders are asked where runs go: a scheme that loses its order in a region of the states is not verified."""

from collections.abc import Callable

import numpy as np
import pytest

from cells import Formula
from facade import (
    Milstein,
    double_well,
    judge_strong,
    judge_weak,
    local_strong,
    local_weak,
    strong_orders,
    weak_order,
)
from probe.weak_cells import equation, euler, heun
from sdaeverify import SDE, Array, Increment, Mask
from sdaeverify.measuring import Opinion, Verdict
from sdaeverify.probe.step.states import SPREAD, cloud, reached_states, spread_states

Region = Callable[[Array], Mask]


def root(x: Array) -> Array:
    """Return the square root of 1 + x^2."""
    return np.asarray(np.sqrt(1.0 + x * x))


def wide() -> SDE:
    """Return dx = -x dt + sqrt(1 + x^2) dW from 0.7."""
    return equation(
        lambda t, x: -x,
        lambda t, x: root(x)[:, None],
        [0.7],
        diffusion_derivative=lambda t, x, y: (x * y / root(x))[:, None],
        traits=frozenset({"diagonal-noise"}),
    )


def plane() -> SDE:
    """Return two coupled components with diagonal noise, which cross both axes."""

    def diffusion(t: float, x: Array) -> Array:
        return np.asarray(root(x)[:, None] * np.eye(2)[..., None])

    return equation(
        lambda t, x: np.stack([-x[0] + 0.3 * np.sin(x[1]), 0.2 * x[0] - 0.5 * x[1]]),
        diffusion,
        [0.7, 0.6],
        noise_dim=2,
        horizon=2.0,
        diffusion_derivative=lambda t, x, y: (x * y / root(x))[:, None] * np.eye(2)[..., None],
        traits=frozenset({"diagonal-noise"}),
    )


def strong(problem: SDE, wrong: Region) -> Opinion:
    """Return what one step says of strong order 1 for Milstein's scheme that is Euler's in a region."""

    def rule(p: SDE, x: Array, h: float, noise: Increment) -> Array:
        return np.where(wrong(x), euler(p, x, 0.0, h, noise), Milstein().step(p, x, 0.0, h, noise).state)

    return judge_strong(strong_orders(local_strong(Formula(rule), problem))[-1], 1.0)


def weak(problem: SDE, wrong: Region) -> Opinion:
    """Return what one step says of weak order 2 for Heun's scheme that is Euler's in a region."""

    def rule(p: SDE, x: Array, h: float, noise: Increment) -> Array:
        return np.where(wrong(x), euler(p, x, 0.0, h, noise), heun(p, x, 0.0, h, noise))

    return judge_weak(weak_order(local_weak(Formula(rule), problem)), 2.0)


def drawn_interval(problem: SDE, seed: int) -> Region:
    """Return a region between two quantiles of the states that solutions reach, of probability 0.04."""
    begin = np.random.default_rng(seed).uniform(0.0, 0.96)
    low, high = np.quantile(reached_states(problem, problem.ito()).points[0], [begin, begin + 0.04])
    return lambda x: np.asarray((x[0] > low) & (x[0] < high))


@pytest.mark.parametrize(
    ("problem", "wrong"),
    [
        (wide(), lambda x: x[0] < -1.0),
        (wide(), lambda x: (x[0] > 0.4) & (x[0] < 0.5)),
        (wide(), lambda x: np.abs(x[0]) < 0.05),
        (plane(), lambda x: x[0] * x[1] < 0.0),
        (plane(), lambda x: (x[0] > 0.5) & (x[1] > 0.5)),
    ],
    ids=["far out", "between two bounds", "small", "of two signs", "in a corner"],
)
def test_strong_order_lost_in_a_region_is_refuted(problem: SDE, wrong: Region) -> None:
    """Milstein's scheme without its correction in a region has strong order 1/2."""
    assert strong(problem, wrong).verdict is Verdict.REFUTED


@pytest.mark.parametrize(
    "wrong",
    [lambda x: x[0] > 1.8, lambda x: (x[0] > 0.4) & (x[0] < 0.5), lambda x: np.abs(x[0]) < 0.05],
    ids=["far out", "between two bounds", "small"],
)
def test_weak_order_lost_in_a_region_is_not_verified(wrong: Region) -> None:
    """Heun's scheme for additive noise that is Euler's in a region has weak order 1, and paths do not verify it."""
    opinion = weak(double_well(), wrong)

    assert opinion.verdict is Verdict.REFUTED or opinion.speaks_against


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(8))
def test_order_lost_in_a_drawn_interval_is_not_verified(seed: int) -> None:
    """An interval of probability 0.04 holds a probed state wherever it lies."""
    assert strong(wide(), drawn_interval(wide(), seed)).verdict is Verdict.REFUTED
    opinion = weak(double_well(), drawn_interval(double_well(), seed))
    assert opinion.verdict is Verdict.REFUTED or opinion.speaks_against


def test_schemes_without_a_wrong_region_keep_their_orders() -> None:
    """Milstein's scheme has strong order 1 and Heun's weak order 2 at all states."""

    def nowhere(x: Array) -> Mask:
        return np.zeros(x.shape[1], dtype=bool)

    assert strong(wide(), nowhere).verdict is Verdict.VERIFIED
    assert strong(plane(), nowhere).verdict is Verdict.VERIFIED
    assert weak(double_well(), nowhere).verdict is Verdict.VERIFIED


def test_large_defects_far_out_do_not_hide_a_small_one_near_the_start() -> None:
    """A defect of order 1/2 at states of the cloud counts beside far states whose own defects are larger."""
    problem = wide()
    x = cloud(problem, problem.ito())[0]

    def rule(p: SDE, y: Array, h: float, noise: Increment) -> Array:
        wrong = 1e-2 * np.isin(y[0], x) * (noise.dW**2 - h)
        allowed = 1e3 * (y[0] > 1.1 * x.max()) * h * noise.dW
        return Milstein().step(p, y, 0.0, h, noise).state + wrong + allowed

    record = local_strong(Formula(rule), problem)
    near, far = record.groups
    far, near = (record.rms[0, group].max(axis=0)[-3:] for group in (far, near))
    assert (far > 10.0 * near).all()
    assert judge_strong(strong_orders(record)[-1], 1.0).verdict is Verdict.REFUTED


def test_spread_states_hold_the_extremes_and_the_middle_of_each_component() -> None:
    """The least and the largest reached value of each component are there, and no more states than allowed."""
    problem = plane()
    reached, x = reached_states(problem, problem.ito()).points, spread_states(problem, problem.ito())

    assert x.shape[1] <= SPREAD
    assert np.array_equal(x.min(axis=1), reached.min(axis=1))
    assert np.array_equal(x.max(axis=1), reached.max(axis=1))
    shares = [(reached[0] <= value).mean() for value in np.sort(x[0])]
    assert np.diff(shares).max() <= 1.0 / (SPREAD // 2 - 1) + 1.0 / reached.shape[1]


def test_spread_states_of_many_components_are_bounded() -> None:
    """Of fifty components with one noise each, no more than the allowed number of states are taken."""
    problem = equation(lambda t, x: -x, lambda t, x: np.eye(50)[..., None], np.zeros(50), noise_dim=50)

    assert 2 <= spread_states(problem, problem.ito(), 20).shape[1] <= 20
