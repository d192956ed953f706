"""Euler-Maruyama, drift-truncated Euler and Milstein against formulas written out by hand."""

from typing import Any

import numpy as np

from facade import DriftTruncatedEuler, Milstein
from sdaeverify import SDE, Array, Increment, Scheme, Step

EPS = np.finfo(float).eps
T, H = 0.3, 0.25
X = np.array([[0.5, -1.0, 2.0, 0.1], [1.5, 0.3, -0.7, 40.0]])
W = np.array([[0.6, -0.2, 0.1, 0.4], [-0.5, 0.9, 0.0, 0.3]])


def sde(noise_dim: int, diffusion: Any, **more: Any) -> SDE:
    return SDE(
        drift=lambda t, x: np.stack([-x[0] + t * x[1], np.sin(x[0]) - x[1]]),
        diffusion=diffusion,
        start=[1.0, 0.5],
        noise_dim=noise_dim,
        horizon=1.0,
        source="made up",
        **more,
    )


def full(t: float, x: Array) -> Array:
    return np.stack([np.stack([x[0] * x[1], 1.0 + 0 * x[0]]), np.stack([np.cos(x[1]), t * x[0] ** 2])])


def diagonal(t: float, x: Array) -> Array:
    zero = 0.0 * x[0]
    return np.stack([np.stack([x[0] ** 2, zero]), np.stack([zero, np.cos(x[1])])])


def single(t: float, x: Array) -> Array:
    return np.stack([x[0] * x[1], np.sin(x[0])])[:, None]


def moved(scheme: Scheme, problem: SDE, noise_dim: int = 2) -> Step:
    W_used = W[:noise_dim]
    return scheme.prepare(problem, H)(X, T, Increment(W_used, np.full_like(W_used, np.nan)))


def assert_rounding(value: Array, expected: Array, terms: float = 8.0) -> None:
    assert np.all(np.abs(value - expected) <= 8 * EPS * terms * np.maximum(1.0, np.abs(expected)))


def euler(f: Array, B_dW: Array, eta: Array | float = 1.0) -> Array:
    return X + eta * H * f + B_dW


def drift() -> Array:
    return np.stack([-X[0] + T * X[1], np.sin(X[0]) - X[1]])


def kicks() -> Array:
    return np.stack([X[0] * X[1] * W[0] + W[1], np.cos(X[1]) * W[0] + T * X[0] ** 2 * W[1]])


def test_drift_truncated_euler_shortens_long_drifts_only() -> None:
    """Where h |f| > 1 the drift is a unit vector, the noise is as it was, and the path is marked."""
    step = moved(DriftTruncatedEuler(), sde(2, full))
    length = H * np.sqrt((drift() ** 2).sum(axis=0))

    assert length.max() > 1.0 > length.min()
    assert step.truncated is not None
    assert np.array_equal(step.truncated, length > 1.0)
    assert_rounding(step.state, euler(drift(), kicks(), np.minimum(1.0, 1.0 / length)))


def test_milstein_takes_the_derivative_it_is_given() -> None:
    """An author's derivative is used in place of complex steps."""
    problem = sde(
        1, lambda t, x: np.abs(x)[:, None] + 1.0, diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None]
    )
    b = np.abs(X) + 1.0

    expected = euler(drift(), b * W[0]) + 0.5 * np.sign(X) * b * (W[0] ** 2 - H)
    assert_rounding(moved(Milstein(), problem, noise_dim=1).state, expected)


def test_milstein_refuses_noise_that_needs_iterated_integrals() -> None:
    """Two Brownian motions that are not declared diagonal are refused, with the reason."""
    assert Milstein().refuses(sde(2, full)) == "noise in 2 dimensions is neither scalar nor diagonal"
    assert not Milstein().refuses(sde(2, diagonal, traits=frozenset({"diagonal-noise"})))
    assert not Milstein().refuses(sde(1, single))


def test_milstein_refuses_a_diffusion_without_derivative() -> None:
    """A diffusion that complex steps cannot differentiate is refused, unless its derivative is given."""

    def rough(t: float, x: Array) -> Array:
        return np.abs(x)[:, None]

    given = sde(1, rough, diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None])

    assert "not analytic" in Milstein().refuses(sde(1, rough))
    assert "diffusion_derivative" in Milstein().refuses(sde(1, rough))
    assert not Milstein().refuses(given)
