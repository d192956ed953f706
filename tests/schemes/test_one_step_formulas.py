"""Higher-order, implicit and tamed schemes against formulas written out path by path."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from facade import SRA1, BalancedEuler, EulerMaruyama, Heun, HeunAdditive, PlatenWeak2, StochasticTheta, TamedEuler
from sdaeverify import SDE, Array, Increment, Scheme, Step
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General

EPS = np.finfo(float).eps
T, H, PATHS = 0.3, 0.25, 5
RNG = np.random.default_rng(17)
X = RNG.uniform(-1.5, 1.5, (2, PATHS))
W, AREA = np.sqrt(H) * RNG.standard_normal((2, PATHS)), np.sqrt(H / 12) * RNG.standard_normal((2, PATHS))


def f(t: float, x: Array) -> Array:
    """Return a drift that depends on time and couples the components, for one path or many."""
    return np.stack([np.sin(x[1]) - x[0] + t**2, x[0] * x[1] - t])


def scalar(t: float, x: Array) -> Array:
    """Return one column of noise that depends on time and state."""
    return np.stack([(1.0 + t) * np.cos(x[1]), x[0] * x[1]])


def own(t: float, x: Array) -> Array:
    """Return the diagonal of a diagonal noise."""
    return np.stack([np.cos(x[0]) + t, x[1] ** 2])


def diagonal(t: float, x: Array) -> Array:
    return own(t, x)[:, None] * np.eye(2)[..., None]


def constant(t: float, x: Array) -> Array:
    return np.array([[0.5, 0.1], [0.3, -0.7]])[..., None]


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


SCALAR = sde(lambda t, x: scalar(t, x)[:, None], 1)
DIAGONAL = sde(diagonal, 2, "diagonal-noise")
ADDITIVE = sde(constant, 2, "additive-noise")


def moved(scheme: Scheme, problem: Any, x: Array = X) -> Step:
    dW = W[: problem.noise_dim]
    area = AREA[: problem.noise_dim] if "H" in scheme.noise else np.full_like(dW, np.nan)
    return scheme.prepare(problem, H)(x, T, Increment(dW, area))


def by_path(formula: Callable[[Array, Array, Array], Array], noise_dim: int = 2, x: Array = X) -> Array:
    """Return a formula of (state, dW, H) of one path at each of the paths."""
    columns = [formula(x[:, p], W[:noise_dim, p], AREA[:noise_dim, p]) for p in range(PATHS)]
    return np.stack(columns, axis=1)


def assert_rounding(value: Array, expected: Array, terms: float = 8.0) -> None:
    assert np.all(np.abs(value - expected) <= 8 * EPS * terms * np.maximum(1.0, np.abs(expected).max()))


A0, B0 = np.zeros((4, 4)), np.zeros((4, 4))
A1, B1 = np.zeros((4, 4)), np.zeros((4, 4))
A0[1, 0], B0[1, 0] = 3 / 4, 3 / 2
A1[1, 0], A1[2, 0], A1[3, 2] = 1 / 4, 1, 1 / 4
B1[1, 0], B1[2, 0], B1[3, :3] = 1 / 2, -1, (-5, 3, 1 / 2)


def test_the_theta_method_solves_its_equation_at_the_new_time() -> None:
    """On a cubic drift that depends on time the new state is the root that bisection finds."""

    def cubic(t: float, x: Array) -> Array:
        return t - x**3

    def formula(x: Array, dW: Array, _: Array) -> Array:
        known = x + 0.4 * H * cubic(T, x) + 0.5 * dW
        roots = [brentq(lambda y, k=k: y - 0.6 * H * cubic(T + H, y) - k, -9, 9, xtol=1e-15) for k in known]
        return np.array(roots)

    problem = sde(lambda t, x: np.full((2, 1, 1), 0.5), 1, drift=cubic)

    assert_rounding(moved(StochasticTheta(0.6), problem).state, by_path(formula, 1), terms=32)


def test_the_theta_method_without_theta_is_explicit() -> None:
    """With theta = 0 there is no Newton step and no need of a derivative of the drift."""
    rough = sde(diagonal, 2, drift=lambda t, x: -np.abs(x))
    step = moved(StochasticTheta(0.0), rough)

    assert np.array_equal(step.state, moved(EulerMaruyama(), rough).state)
    assert step.failed is None
    assert not StochasticTheta(0.0).refuses(rough)
    assert "drift is not analytic" in StochasticTheta(0.5).refuses(rough)


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


def test_the_promise_of_stability_depends_on_theta() -> None:
    """A-stability is promised from theta = 1/2 on, order 2 in law at theta = 1/2 alone."""

    def promised(theta: float) -> dict[str, str]:
        return {claim.measure: str(claim) for claim in StochasticTheta(theta).promises}

    assert [promised(theta)["stability"] for theta in (0.0, 0.499, 0.5, 1.0)] == ["conditional"] * 2 + [
        "A-stable"
    ] * 2
    assert [promised(theta)["weak"] for theta in (0.4, 0.5, 0.6)] == ["order >= 1.0", "order >= 2.0", "order >= 1.0"]


def test_tamed_euler_divides_by_the_length_of_the_drift() -> None:
    """The drift is h f/(1 + h |f|) with the Euclidean length."""

    def formula(x: Array, dW: Array, _: Array) -> Array:
        drift = f(T, x)
        return x + H * drift / (1 + H * np.hypot(*drift)) + own(T, x) * dW

    assert_rounding(moved(TamedEuler(), DIAGONAL).state, by_path(formula))


def test_balanced_euler_solves_its_implicit_equation() -> None:
    """x+ = x + h f + B dW + (|dW_1| + |dW_2|)(x - x+)."""
    new = moved(BalancedEuler(), DIAGONAL).state
    explicit = by_path(lambda x, dW, _: x + H * f(T, x) + own(T, x) * dW)

    assert_rounding(new, explicit + np.abs(W).sum(axis=0) * (X - new))


FULL = sde(lambda t, x: np.stack([x, x[::-1]], axis=1))


def test_noise_that_a_scheme_cannot_do_is_refused() -> None:
    """Schemes for additive or separate noise say which noise they lack."""
    for scheme in (HeunAdditive(), SRA1()):
        assert scheme.refuses(FULL) == "the noise is not declared additive"
        assert not scheme.refuses(ADDITIVE)
    assert not PlatenWeak2General().refuses(FULL)
    assert "platen-weak-2 makes fewer evaluations" in PlatenWeak2General().refuses(SCALAR)
    refused = PlatenWeak2().refuses(FULL)
    assert refused == "noise in 2 dimensions is neither scalar nor diagonal nor additive"
    assert not any(PlatenWeak2().refuses(problem) for problem in (SCALAR, DIAGONAL, ADDITIVE))
    assert "not analytic" in Heun().refuses(sde(lambda t, x: np.abs(x)[:, None], 1))
