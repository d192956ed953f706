"""The projection-based Euler schemes against closed forms, an independent solver and what their source reports."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from facade import ExplicitProjectionEuler, SemiImplicitProjectionEuler, fibre_clamped, fibre_free, pendulum
from facade import _circle as circle
from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, Scheme, Step
from sdaeverify_schemes.projections._new_normals import NORMALS

EPS = np.finfo(float).eps
T = 0.3
EXPLICIT, OLD, NEW = ExplicitProjectionEuler(), SemiImplicitProjectionEuler(), SemiImplicitProjectionEuler("new")
ALL = pytest.mark.parametrize("scheme", [EXPLICIT, OLD, NEW], ids=lambda scheme: scheme.label)


def move(scheme: Scheme, problem: HolonomicSDAE, state: HolonomicState, h: float, dW: Array) -> Step:
    """Make one step from time T; paths without root may divide by zero, as they may in a run."""
    with np.errstate(all="ignore"):
        return scheme.prepare(problem, h)(scheme.enter(problem, state, T, h), T, Increment(dW, None))


@ALL
def test_a_path_without_root_keeps_its_state_and_leaves_its_neighbours_alone(scheme: Scheme) -> None:
    """From the centre of the circle, or from no number, there is no direction: these paths are counted and stay."""
    h, problem = 0.1, pendulum()
    theta = np.array([1.0, 0.0, 2.0, 3.0])
    r, v = circle.normal(theta), 0.3 * circle.tangent(theta)
    v[:, 1], v[:, 3] = -r[:, 1] / h, np.nan
    state, dW = HolonomicState(r, v, np.ones((1, 4))), np.full((2, 4), 0.1)
    calm = state._replace(v=np.where([False, True, False, True], 0.1, v))

    step, alone = (move(scheme, problem, start, h, dW) for start in (state, calm))

    assert step.failed.tolist() == [False, True, False, True]
    parts = scheme.parts(problem, step.state)
    for name, value in state._asdict().items():
        assert np.array_equal(parts[name][:, 1::2], value[:, 1::2], equal_nan=True)
        assert np.array_equal(parts[name][:, ::2], scheme.parts(problem, alone.state)[name][:, ::2])


@pytest.mark.parametrize("skip", [0, 1, 4])
def test_projections_come_after_so_many_skipped_steps(skip: int) -> None:
    """The constraints hold at every (n + 1)-th step, and at no other; what a step took is counted there."""
    scheme, problem, h = ExplicitProjectionEuler(skip=skip), pendulum(), 0.02
    state, stepper, rng = scheme.start(problem, 5, h), scheme.prepare(problem, h), np.random.default_rng(3)
    exact, counted = [], []
    for n in range(15):
        step = stepper(state, n * h, Increment(np.sqrt(h) * rng.standard_normal((2, 5)), None))
        state = step.state
        exact.append(bool(np.abs(problem.constraint(state.r)).max() <= 4 * EPS))
        counted.append(bool((step.costs["projection_iterations"] > 0).all()))

    assert exact == [n % (skip + 1) == skip for n in range(15)]
    assert counted == exact


def test_a_failed_projection_is_tried_again_in_the_next_step() -> None:
    """The path that failed is still due, the other one has begun to skip again."""
    scheme, problem, h = ExplicitProjectionEuler(skip=1), pendulum(), 0.1
    theta = np.array([1.0, 0.0])
    r, v = circle.normal(theta), 0.3 * circle.tangent(theta)
    v[:, 1] = -r[:, 1] / h
    state = scheme.enter(problem, HolonomicState(r, v, np.zeros((1, 2))), 0.0, h)._replace(skipped=np.ones((1, 2)))
    with np.errstate(all="ignore"):
        step = scheme.step(problem, state, 0.0, h, Increment(np.zeros((2, 2)), None))
        again = scheme.step(problem, step.state, h, h, Increment(np.zeros((2, 2)), None))

    assert step.failed.tolist() == again.failed.tolist() == [False, True]
    assert step.state.skipped.tolist() == [[0.0, 1.0]]
    assert again.state.skipped.tolist() == [[1.0, 1.0]]
    assert np.abs(problem.constraint(again.state.r)[0, 0]) > 1e-5


def never(r: Array) -> Array:
    """Stand in for what a structured problem should not be asked for."""
    raise AssertionError("a dense matrix was asked for")


@pytest.mark.parametrize("family", [fibre_clamped, fibre_free])
@pytest.mark.parametrize("scheme", [EXPLICIT, ExplicitProjectionEuler(skip=1), OLD, NEW], ids=lambda s: s.label)
def test_a_fibre_is_asked_for_no_matrix(scheme: Scheme, family: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a chain use its products and tridiagonal systems alone, so that they cost O(N)."""
    problem = family()
    h = problem.horizon / 64
    state, stepper = scheme.start(problem, 3, h), scheme.prepare(problem, h)
    rng = np.random.default_rng(1)
    object.__setattr__(problem, "jacobian", never)
    object.__setattr__(problem, "diffusion", never)
    for n in range(4):
        dW = np.sqrt(h) * rng.standard_normal((problem.noise_dim, 3))
        step = stepper(state, n * h, Increment(dW, None))
        state = step.state

    assert not step.failed.any()
    assert np.isfinite(state.v).all()
    assert np.abs(problem.constraint(state.r)).max() <= 64 * EPS * problem.dimension


@pytest.mark.parametrize("make", [pendulum, lambda: fibre_clamped(alpha=4.0, N=3)])
@pytest.mark.parametrize("scheme", [EXPLICIT, OLD], ids=lambda s: s.label)
def test_newton_finds_the_point_that_the_gram_matrix_does(make: Any, scheme: Scheme) -> None:
    """Both solve the same equations, the Gram matrix up to a part of r; each count has a name of its own."""
    problem, h = make(), 1e-3
    other, dW = replace(scheme, solver="newton"), np.sqrt(h) * np.random.default_rng(2).standard_normal((2, 5))
    dW = np.resize(dW, (problem.noise_dim, 5))
    state = scheme.start(problem, 5, h)
    for n in range(4):
        one, two = (each.prepare(problem, h)(state, n * h, Increment(dW, None)) for each in (scheme, other))
        state = one.state
        assert np.abs(one.state.r - two.state.r).max() <= 2.0 * NORMALS * np.abs(one.state.r).max()

    assert list(one.costs) == ["projection_iterations"]
    assert list(two.costs) == ["newton_iterations"]
    assert not two.failed.any()
    assert two.costs["newton_iterations"].max() <= one.costs["projection_iterations"].max() + 1


def test_a_tolerance_ends_the_projection() -> None:
    """A loose tolerance saves iterations and leaves a defect of its size."""
    problem, h = fibre_clamped(alpha=4.0), 1e-3
    noise = Increment(np.sqrt(h) * np.random.default_rng(4).standard_normal((problem.noise_dim, 20)), None)
    for solver in ("gram", "newton"):
        exact, loose = (ExplicitProjectionEuler(solver=solver, tolerance=size) for size in (0.0, 1e-4))
        state = exact.start(problem, 20, h)
        for _ in range(3):
            state = exact.step(problem, state, 0.0, h, noise).state
        steps = [each.step(problem, state, 0.0, h, noise) for each in (exact, loose)]
        counts = [next(iter(step.costs.values())).sum() for step in steps]
        assert counts[1] < counts[0]
        assert np.abs(problem.constraint(steps[0].state.r)).max() < 1e-12
        assert np.abs(problem.constraint(steps[1].state.r)).max() > 1e-12
        assert not steps[1].failed.any()
