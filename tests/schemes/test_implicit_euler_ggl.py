"""The implicit Euler scheme in GGL form: structure, tolerances, and paths on which Newton's method fails."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from facade import ImplicitEulerGGL, fibre_clamped, fibre_free, pendulum
from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, Step

EPS = np.finfo(float).eps
T, PATHS = 0.3, 8


def move(scheme: ImplicitEulerGGL, problem: HolonomicSDAE, state: HolonomicState, h: float, dW: Array) -> Step:
    """Make one step; away from roots Newton's method may overflow, as it may in a run."""
    with np.errstate(all="ignore"):
        return scheme.prepare(problem, h)(state, T, Increment(dW, None))


def noise(problem: HolonomicSDAE, paths: int, h: float, seed: int = 2) -> Array:
    return np.sqrt(h) * np.random.default_rng(seed).standard_normal((problem.noise_dim, paths))


@pytest.mark.parametrize("make", [fibre_clamped, fibre_free])
@pytest.mark.parametrize("d", [2, 3])
def test_a_chain_moves_as_without_its_structure(make: Any, d: int) -> None:
    """Blocks of nodes and whole matrices give the same steps, up to rounding."""
    chain = make(N=5, d=d)
    whole = dataclasses.replace(chain, structure=None, linearisation=None)
    one = other = chain.initial(4)
    for k in range(3):
        dW = noise(chain, 4, 1e-3, seed=k)
        one, other = (move(ImplicitEulerGGL(), p, s, 1e-3, dW).state for p, s in ((chain, one), (whole, other)))

    for left, right in zip(one, other, strict=True):
        assert np.abs(left - right).max() <= 1e-10 * (1.0 + np.abs(left).max())
    assert np.abs(one.r - chain.initial(4).r).max() > 1e-4


def test_a_tolerance_below_rounding_can_be_met() -> None:
    """On a stiff fine fibre rounding leaves far more of the momentum than the tolerance; no path fails by it."""
    stiff = fibre_clamped(N=40, alpha=0.4, beta=1e-3)
    h = 1e-4
    state = stiff.initial(3)
    for k in range(3):
        step = move(ImplicitEulerGGL(tolerance=1e-14, stages=1), stiff, state, h, noise(stiff, 3, h, seed=k))
        assert not step.failed.any()
        assert step.costs["newton_iterations"].max() <= 5
        state = step.state

    assert h * 16.0 / (0.4 / 41**2) ** 2 * EPS > 1e-12


def test_a_tolerance_ends_the_iteration() -> None:
    """A tolerance saves iterations, and what it leaves of the constraint is below it but more than rounding."""
    fibre = fibre_clamped(alpha=4.0)
    dW = noise(fibre, 20, 1e-3)
    exact, early = (
        move(ImplicitEulerGGL(tolerance=tolerance), fibre, fibre.initial(20), 1e-3, dW) for tolerance in (0.0, 1e-6)
    )
    iterations = [step.costs["newton_iterations"].mean() for step in (exact, early)]
    left = [np.abs(fibre.constraint(step.state.r)).max() for step in (exact, early)]

    assert iterations[0] >= iterations[1] + 0.5
    assert left[0] <= 64 * EPS
    assert 64 * EPS < left[1] <= 1e-6


def coarse() -> tuple[HolonomicSDAE, Array, float]:
    """Return a fibre in strong turbulence with coarse steps, and the noise of the first."""
    h = 1e-2
    fibre = fibre_clamped(alpha=4.0, N=20)
    return fibre, noise(fibre, PATHS, h, seed=0), h


def test_noise_in_parts_leads_paths_to_their_roots() -> None:
    """Paths on which Newton's method ends away from any root get there in stages; the others go where they went."""
    fibre, dW, h = coarse()
    at_once = move(ImplicitEulerGGL(stages=1), fibre, fibre.initial(PATHS), h, dW)
    led = move(ImplicitEulerGGL(), fibre, fibre.initial(PATHS), h, dW)

    assert at_once.failed.any()
    assert not led.failed.any()
    for one, other, start in zip(at_once.state, led.state, fibre.initial(PATHS), strict=True):
        assert np.array_equal(one[:, ~at_once.failed], other[:, ~at_once.failed])
        assert np.array_equal(one[:, at_once.failed], start[:, at_once.failed])
    assert np.abs(fibre.constraint(led.state.r)).max() <= 64 * EPS
    more = led.costs["newton_iterations"] > at_once.costs["newton_iterations"]
    assert np.array_equal(more, at_once.failed)


def test_paths_without_root_keep_their_state() -> None:
    """One iteration is too few for any path: all fail, keep their state bit for bit and are counted."""
    fibre, dW, h = coarse()
    state = fibre.initial(PATHS)._replace(mu=np.ones((20, PATHS)))

    step = move(ImplicitEulerGGL(max_iterations=1), fibre, state, h, dW)

    assert step.failed.all()
    for new, old in zip(step.state, state, strict=True):
        assert np.array_equal(new, old)


def test_a_force_without_derivatives_is_refused() -> None:
    """It is told what to give, and solved with what is given."""

    def derivatives(t: float, r: Array, v: Array) -> tuple[Array, Array]:
        return np.zeros((2, 2, 1)), -np.eye(2)[..., None] * np.sign(v)

    start = {"truths": (), "velocity": pendulum(omega_0=0.5).velocity}
    smooth = dataclasses.replace(pendulum(), force=lambda t, r, v: -np.sqrt(v * v), **start)
    kinked = dataclasses.replace(pendulum(), force=lambda t, r, v: -np.abs(v), **start)
    given = dataclasses.replace(kinked, force_derivatives=derivatives)
    dW = noise(smooth, 4, 1e-3)

    assert "give force_derivatives" in ImplicitEulerGGL().refuses(kinked)
    assert ImplicitEulerGGL().refuses(smooth) == ""
    assert ImplicitEulerGGL().refuses(given) == ""
    one, other = (move(ImplicitEulerGGL(), p, p.initial(4), 1e-3, dW).state for p in (smooth, given))
    assert np.concatenate(one) == pytest.approx(np.concatenate(other), rel=64 * EPS)
