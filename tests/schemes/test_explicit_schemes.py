"""Euler-Maruyama, drift-truncated Euler and Milstein against formulas written out by hand."""

from typing import Any

import numpy as np

from sdaeverify import SDE, Increment
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Scheme, Step
from sdaeverify_schemes.euler_maruyama import DriftTruncatedEuler, EulerMaruyama
from sdaeverify_schemes.milstein import Milstein

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


def test_euler_maruyama_with_full_noise() -> None:
    """Both components get h f and their row of B dW, at the old state and time."""
    assert_rounding(moved(EulerMaruyama(), sde(2, full)).state, euler(drift(), kicks()))


def test_euler_maruyama_with_constant_coefficients() -> None:
    """Coefficients given once for all paths act on each of them."""
    problem = SDE(
        drift=lambda t, x: np.array([[1.0], [-2.0]]),
        diffusion=lambda t, x: np.array([[[0.5], [0.1]], [[0.0], [0.2]]]),
        start=[0.0, 0.0],
        noise_dim=2,
        horizon=1.0,
        source="made up",
    )
    expected = np.stack([X[0] + H + 0.5 * W[0] + 0.1 * W[1], X[1] - 2 * H + 0.2 * W[1]])

    assert_rounding(moved(EulerMaruyama(), problem).state, expected)
    assert moved(DriftTruncatedEuler(), problem).state.shape == X.shape


def test_drift_truncated_euler_shortens_long_drifts_only() -> None:
    """Where h |f| > 1 the drift is a unit vector, the noise is as it was, and the path is marked."""
    step = moved(DriftTruncatedEuler(), sde(2, full))
    length = H * np.sqrt((drift() ** 2).sum(axis=0))

    assert length.max() > 1.0 > length.min()
    assert step.truncated is not None
    assert np.array_equal(step.truncated, length > 1.0)
    assert_rounding(step.state, euler(drift(), kicks(), np.minimum(1.0, 1.0 / length)))


def test_drift_truncated_euler_is_euler_maruyama_where_drifts_are_short() -> None:
    """Where h |f| <= 1 both give the same bits."""
    short, plain = moved(DriftTruncatedEuler(), sde(2, full)), moved(EulerMaruyama(), sde(2, full))

    assert short.truncated is not None
    assert np.array_equal(short.state[:, ~short.truncated], plain.state[:, ~short.truncated])


def test_drift_truncated_euler_starts_at_unit_length() -> None:
    """A drift of length h |f| = 0.99 is left alone, one of 1.01 is shortened to 1."""
    problem = SDE(
        drift=lambda t, x: x,
        diffusion=lambda t, x: np.zeros((1, 1, 1)),
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )
    x, nothing = np.array([[0.99, 1.01, -0.99, -1.01]]) / H, np.zeros((1, 4))

    step = DriftTruncatedEuler().step(problem, x, T, H, Increment(nothing, nothing))

    assert np.array_equal(step.truncated, [False, True, False, True])
    assert_rounding(step.state - x, np.array([[0.99, 1.0, -0.99, -1.0]]), terms=4.0 / H)


def test_drift_truncated_euler_stands_where_there_is_no_drift() -> None:
    """Without drift nothing is divided by zero."""
    problem = SDE(
        drift=lambda t, x: 0.0 * x,
        diffusion=full,
        start=[1.0, 0.5],
        noise_dim=2,
        horizon=1.0,
        source="made up",
    )
    step = moved(DriftTruncatedEuler(), problem)

    assert_rounding(step.state, X + kicks())
    assert step.truncated is not None
    assert not step.truncated.any()


def test_milstein_with_diagonal_noise() -> None:
    """Component j gets (1/2) b_j b_j' (dW_j^2 - h) beside the Euler step."""
    problem = sde(2, diagonal, traits=frozenset({"diagonal-noise"}))
    b = np.stack([X[0] ** 2, np.cos(X[1])])
    slope = np.stack([2 * X[0], -np.sin(X[1])])
    expected = euler(drift(), b * W) + 0.5 * b * slope * (W**2 - H)

    assert_rounding(moved(Milstein(), problem).state, expected)


def test_milstein_with_one_brownian_motion() -> None:
    """All components get (1/2) DB B (dW^2 - h), with the full derivative of the column B."""
    b = np.stack([X[0] * X[1], np.sin(X[0])])
    DB_B = np.stack([X[1] * b[0] + X[0] * b[1], np.cos(X[0]) * b[0]])
    expected = euler(drift(), b * W[0]) + 0.5 * DB_B * (W[0] ** 2 - H)

    assert_rounding(moved(Milstein(), sde(1, single), noise_dim=1).state, expected)


def test_milstein_takes_the_derivative_it_is_given() -> None:
    """An author's derivative is used in place of complex steps."""
    problem = sde(
        1, lambda t, x: np.abs(x)[:, None] + 1.0, diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None]
    )
    b = np.abs(X) + 1.0

    expected = euler(drift(), b * W[0]) + 0.5 * np.sign(X) * b * (W[0] ** 2 - H)
    assert_rounding(moved(Milstein(), problem, noise_dim=1).state, expected)


def test_milstein_is_euler_maruyama_with_constant_noise() -> None:
    """Without a derivative of B there is no correction."""
    problem = sde(1, lambda t, x: np.array([[[0.5]], [[2.0]]]))

    milstein, plain = (moved(scheme, problem, noise_dim=1).state for scheme in (Milstein(), EulerMaruyama()))

    assert np.array_equal(milstein, plain)


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


def test_euler_maruyama_on_a_constrained_problem_solves_the_saddle_point_system(body: Any) -> None:
    """The step of the inherent SDE accelerates as [M, -Dg^T; Dg, 0] (dv, dmu) = (impulse, -D^2 g(v, v) dt) says."""
    r, v, _ = body.state
    n, m = len(r), len(body.state.mu)
    dW = np.random.default_rng(9).standard_normal((2, r.shape[1])) * np.sqrt(0.1)
    view = body.problem.view(SDE)

    new = EulerMaruyama().step(view, np.concatenate([r, v]), T, 0.1, Increment(dW, dW)).state

    a, B = body.problem.force(T, r, v), body.problem.diffusion(T, r, v)
    for p in range(r.shape[1]):
        Dg = body.jacobian(r[:, p])
        saddle = np.block([[body.mass, -Dg.T], [Dg, np.zeros((m, m))]])
        impulse = 0.1 * a[:, p] + B[..., p] @ dW[:, p]
        right = np.concatenate([impulse, -0.1 * body.curvature(v[:, p], v[:, p])])
        dv = np.linalg.solve(saddle, right)[:n]
        scale = np.linalg.cond(saddle) * max(1.0, np.abs(right).max())
        assert np.abs(new[:n, p] - (r + 0.1 * v)[:, p]).max() <= 8 * EPS
        assert np.abs(new[n:, p] - (v[:, p] + dv)).max() <= 8 * EPS * scale
