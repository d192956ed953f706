"""Schemes for SDEs against formulas written out, and what they refuse."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from facade import (
    SRA1,
    BalancedEuler,
    DriftTruncatedEuler,
    EulerMaruyama,
    Heun,
    HeunAdditive,
    Milstein,
    PlatenWeak2,
    ProjectedEuler,
    StochasticTheta,
    TamedEuler,
    circle,
    gbm,
)
from sdaeverify import SDE, Array, Increment, Scheme, Step
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General

EPS = np.finfo(float).eps
T, H, PATHS = 0.3, 0.25, 5
RNG = np.random.default_rng(17)
X, W = RNG.uniform(-1.5, 1.5, (2, PATHS)), np.sqrt(H) * RNG.standard_normal((2, PATHS))


def f(t: float, x: Array) -> Array:
    """Return a drift that depends on time and couples the components."""
    return np.stack([np.sin(x[1]) - x[0] + t**2, x[0] * x[1] - t])


def own(t: float, x: Array) -> Array:
    """Return the diagonal of a diagonal noise."""
    return np.stack([np.cos(x[0]) + t, x[1] ** 2])


def sde(diffusion: Any, noise_dim: int = 2, *traits: str, **more: Any) -> SDE:
    return SDE(
        **{"drift": f, **more},
        diffusion=diffusion,
        start=[1.0, 0.5],
        noise_dim=noise_dim,
        horizon=1.0,
        source="made up",
        traits=frozenset(traits),
    )


def rough(t: float, x: Array) -> Array:
    """Return noise that complex steps cannot differentiate."""
    return np.abs(x)[:, None] + 1.0


SCALAR = sde(lambda t, x: np.stack([(1.0 + t) * np.cos(x[1]), x[0] * x[1]])[:, None], 1)
DIAGONAL = sde(lambda t, x: own(t, x)[:, None] * np.eye(2)[..., None], 2, "diagonal-noise")
ADDITIVE = sde(lambda t, x: np.array([[0.5, 0.1], [0.3, -0.7]])[..., None], 2, "additive-noise")
FULL = sde(lambda t, x: np.stack([x, x[::-1]], axis=1))
ROUGH = sde(rough, 1)
KINKED = sde(DIAGONAL.diffusion, 2, drift=lambda t, x: -np.abs(x))
GIVEN = sde(rough, 1, diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None])


def moved(scheme: Scheme, problem: Any, x: Array = X) -> Step:
    dW = W[: problem.noise_dim]
    return scheme.prepare(problem, H)(x, T, Increment(dW, np.full_like(dW, np.nan)))


def assert_rounding(value: Array, expected: Array, terms: float = 8.0) -> None:
    assert np.all(np.abs(value - expected) <= 8 * EPS * terms * np.maximum(1.0, np.abs(expected).max()))


DRIFT, KICK = f(T, X), own(T, X) * W
LENGTH = np.hypot(*DRIFT)
B = rough(T, X)[:, 0]
FORMULAS: dict[str, tuple[Scheme, SDE, Array]] = {
    # The drift is h f/(1 + h |f|) with the Euclidean length.
    "tamed": (TamedEuler(), DIAGONAL, X + H * DRIFT / (1 + H * LENGTH) + KICK),
    # x+ = x + h f + B dW + (|dW_1| + |dW_2|)(x - x+).
    "balanced": (BalancedEuler(), DIAGONAL, X + (H * DRIFT + KICK) / (1.0 + np.abs(W).sum(axis=0))),
    # An author's derivative is used in place of complex steps.
    "milstein": (Milstein(), GIVEN, X + H * DRIFT + B * W[0] + 0.5 * np.sign(X) * B * (W[0] ** 2 - H)),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_a_step_is_its_formula(name: str) -> None:
    """To rounding, on paths where truncation, taming and noise make a difference."""
    scheme, problem, expected = FORMULAS[name]

    assert_rounding(moved(scheme, problem).state, expected)


def test_drift_truncated_euler_shortens_long_drifts_only() -> None:
    """Where h |f| > 1 the drift is a unit vector, the noise is as it was, and the path is marked."""
    x = 4.0 * X
    length = H * np.hypot(*f(T, x))

    assert length.max() > 1.0 > length.min()
    step = moved(DriftTruncatedEuler(), DIAGONAL, x)
    assert np.array_equal(step.truncated, length > 1.0)
    assert_rounding(step.state, x + f(T, x) * np.minimum(H, H / length) + own(T, x) * W)


def test_the_theta_method_solves_its_equation_at_the_new_time() -> None:
    """On a cubic drift that depends on time the new state is the root that bisection finds."""
    problem = sde(lambda t, x: np.full((2, 1, 1), 0.5), 1, drift=lambda t, x: t - x**3)
    known = X + 0.4 * H * (T - X**3) + 0.5 * W[0]
    roots = [brentq(lambda y, k=k: y - 0.6 * H * (T + H - y**3) - k, -9, 9, xtol=1e-15) for k in known.ravel()]

    assert_rounding(moved(StochasticTheta(0.6), problem).state, np.reshape(roots, X.shape), terms=32)


def test_the_theta_method_without_theta_is_explicit() -> None:
    """With theta = 0 there is no Newton step and no need of a derivative of the drift."""
    step = moved(StochasticTheta(0.0), KINKED)

    assert np.array_equal(step.state, moved(EulerMaruyama(), KINKED).state)
    assert step.failed is None


def test_the_theta_method_holds_a_path_without_root() -> None:
    """Where y = x + h y^2 has no root, on large states, the path keeps its state and is counted."""
    problem = sde(lambda t, x: np.zeros((2, 1, 1)), 1, drift=lambda t, x: x * x + 0.0 * t)
    x = np.array([[0.1, 30.0, 0.2, 1.1, -2.0]] * 2)

    with np.errstate(all="ignore"):
        step = moved(StochasticTheta(1.0), problem, x)

    # Discriminant 1 - 4 h x.
    lost = 1.0 - 4.0 * H * x[0] < 0.0
    assert np.array_equal(step.failed, lost)
    assert np.array_equal(step.state[:, lost], x[:, lost])
    root = (1.0 - np.sqrt(1.0 - 4.0 * H * x[:, ~lost])) / (2.0 * H)
    assert_rounding(step.state[:, ~lost], root, terms=32)


REFUSED: list[tuple[Scheme, Any, str]] = [
    *[(scheme, FULL, "the noise is not declared additive") for scheme in (HeunAdditive(), SRA1())],
    (Heun(), ROUGH, "not analytic"),
    (Milstein(), FULL, "noise in 2 dimensions is neither scalar nor diagonal"),
    (Milstein(), ROUGH, "not analytic"),
    (Milstein(), ROUGH, "diffusion_derivative"),
    (PlatenWeak2(), FULL, "noise in 2 dimensions is neither scalar nor diagonal nor additive"),
    (PlatenWeak2General(), SCALAR, "platen-weak-2 needs fewer evaluations"),
    (ProjectedEuler(), gbm(), "the problem has no constraint to project onto"),
    (StochasticTheta(0.5), KINKED, "drift is not analytic"),
]
TAKEN: list[tuple[Scheme, Any]] = [
    *[(scheme, ADDITIVE) for scheme in (HeunAdditive(), SRA1())],
    *[(Milstein(), problem) for problem in (SCALAR, DIAGONAL, GIVEN)],
    *[(PlatenWeak2(), problem) for problem in (SCALAR, DIAGONAL, ADDITIVE)],
    (PlatenWeak2General(), FULL),
    (ProjectedEuler(), circle()),
    (StochasticTheta(0.0), KINKED),
]


def test_what_a_scheme_cannot_do_is_refused() -> None:
    """The reason says which noise, derivative or constraint is missing; what can be done is not refused."""
    assert [reason for scheme, problem, reason in REFUSED if reason not in scheme.refuses(problem)] == []
    assert [scheme.refuses(problem) for scheme, problem in TAKEN if scheme.refuses(problem)] == []
