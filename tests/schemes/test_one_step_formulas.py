"""Higher-order, implicit and tamed schemes against formulas written out path by path."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from sdaeverify import SDE, Increment, Langevin, ParameterError
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Scheme, Step
from sdaeverify.noise.laws import THREE_POINT
from sdaeverify_schemes.balanced_euler import BalancedEuler
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import EulerMaruyama, TamedEuler
from sdaeverify_schemes.heun import Heun, HeunAdditive
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1
from sdaeverify_schemes.stochastic_theta import StochasticTheta

EPS = np.finfo(float).eps
T, H, PATHS = 0.3, 0.25, 5
RNG = np.random.default_rng(17)
X = RNG.uniform(-1.5, 1.5, (2, PATHS))
W, AREA = np.sqrt(H) * RNG.standard_normal((2, PATHS)), np.sqrt(H / 12) * RNG.standard_normal((2, PATHS))

Vector = Callable[[float, Array], Array]


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


def slope(b: Callable[[Array], Array], x: Array, y: Array) -> Array:
    """Return Db(x) y by a complex step."""
    return np.imag(b(x + 1e-100j * y)) / 1e-100


def test_heun_with_one_noise() -> None:
    """The trapezoidal rule is applied to f - Db b/2 and b, with the predictor at the new time."""

    def F(t: float, x: Array) -> Array:
        return f(t, x) - 0.5 * slope(lambda z: scalar(t, z), x, scalar(t, x))

    def formula(x: Array, dW: Array, _: Array) -> Array:
        y = x + H * F(T, x) + scalar(T, x) * dW
        return x + 0.5 * H * (F(T, x) + F(T + H, y)) + 0.5 * (scalar(T, x) + scalar(T + H, y)) * dW

    assert_rounding(moved(Heun(), SCALAR).state, by_path(formula, 1))


def test_heun_with_two_noises_sums_their_corrections() -> None:
    """Each column contributes its own Db_j b_j to the Stratonovich drift."""
    columns: list[Vector] = [scalar, lambda t, x: np.stack([x[1], np.sin(x[0])])]

    def F(t: float, x: Array) -> Array:
        return f(t, x) - 0.5 * sum(slope(lambda z, b=b: b(t, z), x, b(t, x)) for b in columns)

    def formula(x: Array, dW: Array, _: Array) -> Array:
        kick = sum(b(T, x) * w for b, w in zip(columns, dW, strict=True))
        y = x + H * F(T, x) + kick
        later = sum(b(T + H, y) * w for b, w in zip(columns, dW, strict=True))
        return x + 0.5 * H * (F(T, x) + F(T + H, y)) + 0.5 * (kick + later)

    problem = sde(lambda t, x: np.stack([b(t, x) for b in columns], axis=1))
    assert_rounding(moved(Heun(), problem).state, by_path(formula))


def test_heun_with_additive_noise() -> None:
    """The predictor has the noise in it and the new time."""

    def formula(x: Array, dW: Array, _: Array) -> Array:
        kick = constant(T, x)[..., 0] @ dW
        return x + 0.5 * H * (f(T, x) + f(T + H, x + H * f(T, x) + kick)) + kick

    assert_rounding(moved(HeunAdditive(), ADDITIVE).state, by_path(formula))
    assert_rounding(moved(Heun(), ADDITIVE).state, by_path(formula))


def test_sra1_is_roessler_s_tableau() -> None:
    """Coefficients alpha = (1/3, 2/3), A = 3/4, B = 3/2, c = (0, 3/4), beta_1 = (1, 0), beta_2 = (-1, 1).

    The noise is taken at (t + h, t), so that noise may depend on time, though no trait says so.
    """

    def b(t: float) -> Array:
        return np.array([[0.5 + t, 0.1], [0.3, t**2]])

    def formula(x: Array, dW: Array, area: Array) -> Array:
        I10 = H * (area + 0.5 * dW)
        stage = x + 0.75 * H * f(T, x) + 1.5 * b(T + H) @ I10 / H
        drift = H * (f(T, x) / 3 + 2 * f(T + 0.75 * H, stage) / 3)
        return x + drift + b(T + H) @ (dW - I10 / H) + b(T) @ (I10 / H)

    problem = sde(lambda t, x: b(t)[..., None])
    assert_rounding(moved(SRA1(), problem).state, by_path(formula))


C0, C1 = [0, 3 / 4, 0, 0], [0, 1 / 4, 1, 1 / 4]
A0, B0 = np.zeros((4, 4)), np.zeros((4, 4))
A1, B1 = np.zeros((4, 4)), np.zeros((4, 4))
A0[1, 0], B0[1, 0] = 3 / 4, 3 / 2
A1[1, 0], A1[2, 0], A1[3, 2] = 1 / 4, 1, 1 / 4
B1[1, 0], B1[2, 0], B1[3, :3] = 1 / 2, -1, (-5, 3, 1 / 2)
ALPHA = [1 / 3, 2 / 3, 0, 0]
BETA = np.array([[-1, 4 / 3, 2 / 3, 0], [-1, 4 / 3, -1 / 3, 0], [2, -4 / 3, -2 / 3, 0], [-2, 5 / 3, -2 / 3, 1]])


def roessler(b: Vector, x: Array, dW: Array, area: Array) -> Array:
    """Return a step of the general scheme with four stages of either kind and the tableau of SRI1W1."""
    I10 = H * (area + 0.5 * dW)
    integrals = np.array([dW, 0.5 * (dW**2 - H) / np.sqrt(H), I10 / H, (dW**3 - 3 * H * dW) / (6 * H)])
    drifts: list[Array] = []
    noises: list[Array] = []
    for i in range(4):
        along = x + sum(A0[i, j] * drifts[j] * H + B0[i, j] * noises[j] * I10 / H for j in range(i))
        across = x + sum(A1[i, j] * drifts[j] * H + B1[i, j] * noises[j] * np.sqrt(H) for j in range(i))
        drifts.append(f(T + C0[i] * H, along))
        noises.append(b(T + C1[i] * H, across))
    kick = sum((weights @ integrals) * noise for weights, noise in zip(BETA.T, noises, strict=True))
    return np.asarray(x + H * sum(a * drift for a, drift in zip(ALPHA, drifts, strict=True)) + kick)


def test_sri1w1_is_roessler_s_tableau() -> None:
    """With one noise and with diagonal noise the step is the general scheme with the published coefficients."""
    with_one = by_path(lambda x, dW, area: roessler(scalar, x, dW, area), 1)
    diagonally = by_path(lambda x, dW, area: roessler(own, x, dW, area))

    assert_rounding(moved(SRI1W1(), SCALAR).state, with_one, terms=64)
    assert_rounding(moved(SRI1W1(), DIAGONAL).state, diagonally, terms=64)


def platen(b: list[Vector], x: Array, dW: Array) -> Array:
    """Return (15.1.3) of Kloeden & Platen without its terms of r != j, which vanish where columns do not mix.

    Time is a further component without noise: supporting values are at t + h.
    """
    kicks = sum(b_j(T, x) * w for b_j, w in zip(b, dW, strict=True))
    new = x + 0.5 * H * (f(T, x) + f(T + H, x + H * f(T, x) + kicks))
    for b_j, w in zip(b, dW, strict=True):
        up, down = (b_j(T + H, x + H * f(T, x) + sign * b_j(T, x) * np.sqrt(H)) for sign in (1, -1))
        new = new + 0.25 * (up + down + 2 * b_j(T, x)) * w + 0.25 * (up - down) * (w**2 - H) / np.sqrt(H)
    return new


def mixed(b: list[Vector], x: Array, dW: Array, signs: Array) -> Array:
    """Return the terms of r != j in (15.1.3), for two noises and V_12 = h times the product of two signs."""
    new, V = 0.0 * x, np.array([[0.0, 1.0], [-1.0, 0.0]]) * H * signs[0] * signs[1]
    for j, r in ((0, 1), (1, 0)):
        up, down = (b[j](T, x + sign * b[r](T, x) * np.sqrt(H)) for sign in (1, -1))
        new = new + 0.25 * (up + down - 2 * b[j](T, x)) * dW[j]
        new = new + 0.25 * (up - down) * (dW[j] * dW[r] + V[r, j]) / np.sqrt(H)
    return new


def test_platen_with_noises_that_do_not_commute() -> None:
    """The general scheme has the terms of r != j, too, with signs in place of H."""
    columns: list[Vector] = [scalar, lambda t, x: np.stack([x[1] * t, np.sin(x[0])])]
    problem = sde(lambda t, x: np.stack([b(t, x) for b in columns], axis=1))
    noise = THREE_POINT.increment(Increment(W, AREA), H)

    new = PlatenWeak2General().step(problem, X, T, H, noise).state

    signs = np.sign(AREA)
    expected = [
        platen(columns, X[:, p], noise.dW[:, p]) + mixed(columns, X[:, p], noise.dW[:, p], signs[:, p])
        for p in range(PATHS)
    ]
    assert_rounding(new, np.stack(expected, axis=1), terms=32)


COLUMNS: list[Vector] = [
    lambda t, x: np.array([own(t, x)[0], 0.0]),
    lambda t, x: np.array([0.0, own(t, x)[1]]),
]


def test_platen_with_one_noise() -> None:
    """The scheme of weak order 2 for one noise."""
    assert_rounding(moved(PlatenWeak2(), SCALAR).state, by_path(lambda x, dW, _: platen([scalar], x, dW), 1))


def test_platen_with_diagonal_noise_gives_each_column_its_supporting_values() -> None:
    """Taking all supporting values at once is the same where columns depend on their own component."""
    assert_rounding(moved(PlatenWeak2(), DIAGONAL).state, by_path(lambda x, dW, _: platen(COLUMNS, x, dW)))


def test_platen_with_additive_noise_is_heun() -> None:
    """Constant columns leave the trapezoidal rule in the drift."""
    assert_rounding(moved(PlatenWeak2(), ADDITIVE).state, moved(HeunAdditive(), ADDITIVE).state)


def test_platen_takes_three_point_variables() -> None:
    """Its law has mean 0, variance 1 and fourth moment 3 on three atoms."""
    assert PlatenWeak2.law is THREE_POINT
    x, w = np.array(THREE_POINT.values), np.array(THREE_POINT.weights)
    assert np.abs([w.sum() - 1, w @ x, w @ x**2 - 1, w @ x**3, w @ x**4 - 3, w @ x**5]).max() <= 16 * EPS


@pytest.mark.parametrize("theta", [0.25, 0.5, 1.0])
def test_the_theta_method_on_a_linear_equation(theta: float) -> None:
    """On dx = a x dt + b x dW the step multiplies by (1 + (1 - theta) a h + b dW)/(1 - theta a h)."""
    a, b = -3.0, 0.8
    problem = sde(lambda t, x: b * x[:, None], 1, drift=lambda t, x: a * x)
    factor = (1 + (1 - theta) * a * H + b * W[0]) / (1 - theta * a * H)

    step = moved(StochasticTheta(theta), problem)

    assert_rounding(step.state, factor * X)
    # The first update solves the linear equation, the second finds nothing left.
    assert np.all(step.costs["newton_iterations"] == 2)
    assert not step.failed.any()


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


@pytest.mark.parametrize("theta", [-0.1, 1.1, np.nan])
def test_theta_is_a_share(theta: float) -> None:
    """A value of theta outside 0 to 1 is refused."""
    with pytest.raises(ParameterError, match=r"theta .*must be (between 0 and 1|finite)"):
        StochasticTheta(theta)


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


@pytest.mark.parametrize("gamma", [0.0, 0.7])
def test_baoab_is_its_five_steps(gamma: float) -> None:
    """Half a kick, half a move, friction and noise, half a move, half a kick."""
    problem = Langevin(
        force=lambda q: -np.sin(q),
        friction=gamma,
        strength=0.9,
        position=[0.0],
        momentum=[0.0],
        horizon=1.0,
        source="made up",
    )

    def formula(x: Array, dW: Array, _: Array) -> Array:
        (q, p), c = x, np.exp(-gamma * H)
        p = p - 0.5 * H * np.sin(q)
        q = q + 0.5 * H * p
        spread = 0.9 * np.sqrt((1 - c * c) / (2 * gamma) if gamma else H)
        p = c * p + spread * dW[0] / np.sqrt(H)
        q = q + 0.5 * H * p
        return np.array([q, p - 0.5 * H * np.sin(q)])

    assert_rounding(moved(BAOAB(), problem).state, by_path(formula, 1))


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
