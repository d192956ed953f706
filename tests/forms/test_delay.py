"""The form of delay SDAEs: what it refuses, its derivatives, y solved for, its views and residuals."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from facade import delay_linear, delay_martingale, delay_ou, delay_test, gbm_algebraic, noisy_circuit
from forms.refusing import refusal
from sdaeverify import SDE, Array, DelaySDAE, HolonomicSDAE, ParameterError, Partials

EPS = np.finfo(float).eps


def drift(t: float, x: Array, v: Array, y: Array) -> Array:
    return np.stack([np.sin(x[1]) - x[0] * v[1] + y[0], np.exp(-v[0]) - x[1] * y[0] + t])


def drift_partials(t: float, x: Array, v: Array, y: Array) -> Partials:
    zero, one = 0.0 * x[0], 1.0 + 0.0 * x[0]
    return Partials(
        np.stack([np.stack([-v[1], np.cos(x[1])]), np.stack([zero, -y[0]])]),
        np.stack([np.stack([zero, -x[0]]), np.stack([-np.exp(-v[0]), zero])]),
        np.stack([one, -x[1]])[:, None],
    )


def diffusion(t: float, x: Array, v: Array, y: Array) -> Array:
    return np.stack([np.stack([x[0], v[1]]), np.stack([y[0], 1.0 + 0.0 * x[0]])])


def constraint(t: float, x: Array, v: Array, y: Array) -> Array:
    return (y[0] + y[0] ** 3 - x[0] * v[1] + x[1] - t)[None]


def constraint_partials(t: float, x: Array, v: Array, y: Array) -> Partials:
    zero, one = 0.0 * x[0], 1.0 + 0.0 * x[0]
    return Partials(np.stack([-v[1], one])[None], np.stack([zero, -x[0]])[None], (1.0 + 3.0 * y[0] ** 2)[None, None])


def make(**changes: Any) -> DelaySDAE:
    """Return a valid problem with some of its arguments changed."""
    valid = {
        "drift": drift,
        "diffusion": diffusion,
        "constraint": constraint,
        "algebraic": 1,
        "delay": 0.5,
        "history": lambda t: [1.0 + t, 0.5 - t],
        "noise_dim": 2,
        "horizon": 1.0,
        "source": "made up",
    }
    return DelaySDAE(**{**valid, **changes})


def states(paths: int = 5) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(2)
    return rng.standard_normal((2, paths)), rng.standard_normal((2, paths)), rng.standard_normal((1, paths))


def kinked(t: float, x: Array, v: Array, y: Array) -> Array:
    return y - np.abs(x[:1] - 1.0)


def linear(t: float, x: Array, v: Array, y: Array) -> Array:
    return y - x[:1]


def wrong_partials(t: float, x: Array, v: Array, y: Array) -> Partials:
    unit = np.eye(2)[..., None] + 0.0 * x[:1]
    return Partials(5.0 * unit, 0.0 * unit, np.zeros((2, 0, 1)))


LINEAR: dict[str, Any] = {"constraint": linear, "algebraic": [1.0]}
BARE: dict[str, Any] = {
    "constraint": None,
    "algebraic": None,
    "drift": lambda t, x, v, y: -1.0 * x,
    "diffusion": lambda t, x, v, y: 0.0 * x[:, None] + np.eye(2)[..., None],
}
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"delay": -0.1}, "delay must be finite and not negative, got -0.1"),
    ({"algebraic": 0}, "algebraic must be y at time 0 or a number of at least 1"),
    ({"algebraic": True}, "algebraic must be y at time 0 or a number of at least 1"),
    ({"algebraic": None}, "constraint and algebraic, the y at time 0 or their number, must be given together"),
    ({"constraint": None}, "constraint and algebraic, the y at time 0 or their number, must be given together"),
    ({"history": lambda t: [1.0, np.nan]}, "history(0.0) must be a vector of finite numbers, got [1.0, nan]"),
    ({"history": lambda t: 1.0}, "history(0.0) must be a vector of finite numbers, got 1.0"),
    ({"history": lambda t: [1.0] * (2 if t == 0.0 else 3)}, "has 3 components, history(0.0) has 2"),
    ({"history": lambda t: [np.nan if -0.4 < t < -0.1 else 1.0, 0.5]}, ") must be a vector of finite numbers"),
    ({"history": lambda t: [1.0] if -0.4 < t < -0.1 else [1.0, 0.5]}, "has 1 components, history(0.0) has 2"),
    ({"drift": lambda t, x, v, y: x[:1]}, "drift(t, x, v, y) returned shape (1, 3), expected (2, 3) for 3 paths"),
    ({"drift": lambda t, x, v, y: None}, "drift(t, x, v, y) returned NoneType"),
    ({"drift": lambda t, x, v, y: x / 0.0 * 0.0}, "drift(t, x, v, y) is not finite at the initial state"),
    ({"diffusion": lambda t, x, v, y: x}, "diffusion(t, x, v, y) returned shape (2, 3), expected (2, 2, 3)"),
    ({"noise_dim": 1}, "diffusion(t, x, v, y) returned shape (2, 2, 3), expected (2, 1, 3)"),
    ({"constraint": lambda t, x, v, y: y[0]}, "constraint(t, x, v, y) returned shape (3,), expected (1, 3)"),
    ({"algebraic": [0.3, 0.1]}, "constraint(t, x, v, y) returned shape (1, 3), expected (2, 3)"),
    ({"algebraic": [0.9]}, "algebraic: y = [0.9] at time 0 violates constraint = 0; it is solved by ["),
    ({"algebraic": [np.nan]}, "algebraic must be a vector of finite numbers, got [nan]"),
    ({"constraint": lambda t, x, v, y: y**2 + x[:1]}, "the constraint has no solution y at time 0"),
    ({"constraint": lambda t, x, v, y: x[:1] - 1.0 + 0.0 * y, "algebraic": [0.0]}, "the problem has not index 1"),
    ({"constraint": lambda t, x, v, y: y**2, "algebraic": [0.0]}, "the problem has not index 1; du/dy = [[0.0]]"),
    ({**BARE, "drift_partials": wrong_partials}, "drift_partials(t, x, v, y).x disagrees"),
    ({**LINEAR, "solved": lambda t, x, v: x[:1] ** 2}, "solved(t, x, v) leaves constraint = "),
    ({**LINEAR, "solved": lambda t, x, v: 1.0 * x}, "solved(t, x, v) returned shape"),
    ({"constraint": kinked, "algebraic": [0.0]}, "constraint is not analytic (abs or a real array?); give"),
    (
        {"drift_partials": lambda *at: drift_partials(*at)._replace(v=2.0 * drift_partials(*at).v)},
        "drift_partials(t, x, v, y).v disagrees with a difference quotient",
    ),
    (
        {"drift_partials": lambda *at: drift_partials(*at)._replace(y=0.0 * drift_partials(*at).y)},
        "drift_partials(t, x, v, y).y disagrees with a difference quotient",
    ),
    (
        {"constraint_partials": lambda *at: constraint_partials(*at)._replace(x=-constraint_partials(*at).x)},
        "constraint_partials(t, x, v, y).x disagrees with a difference quotient",
    ),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=[text for _, text in REFUSED])
def test_contradictory_problems_are_refused_in_one_line(changes: dict[str, Any], message: str) -> None:
    """The message says what was expected and what was given."""
    assert message in refusal(make, **changes)


FAMILIES: list[tuple[Callable[[], DelaySDAE], str]] = [
    (lambda: delay_test("VII"), "set must be one of I, II, III, IV, V, VI, got 'VII'"),
    (lambda: delay_ou(tau=0.0), "tau must be positive and finite, got 0.0"),
    (lambda: delay_linear(tau=-1.0), "tau must be positive and finite, got -1.0"),
    (lambda: delay_martingale(tau=np.nan), "tau must be positive and finite, got nan"),
    (lambda: noisy_circuit(R_a=0.0), "R_a must be positive and finite, got 0.0"),
    (lambda: noisy_circuit(temperature=-1.0), "temperature must be finite and not negative, got -1.0"),
]


@pytest.mark.parametrize(("family", "message"), FAMILIES, ids=[text for _, text in FAMILIES])
def test_impossible_parameters_are_refused_in_one_line(family: Callable[[], DelaySDAE], message: str) -> None:
    """Unknown sets, delays and elements that are not positive are told."""
    assert message in refusal(family, ParameterError)


def test_y_is_solved_for_at_the_start() -> None:
    """Of the number of algebraic components, the y with y + y^3 = x_0 v_1 - x_1 is found."""
    y = make().initial(1).y[0, 0]

    assert y + y**3 == pytest.approx(1.0 * 1.0 - 0.5, rel=8 * EPS)
    assert make(algebraic=[y]).initial(3).y.tolist() == [[y] * 3]


def test_y_is_a_differentiable_function_of_x_and_v() -> None:
    """U solves the constraint on every path, and a complex step through Newton's method gives -u_y^{-1} u_x."""
    problem, (x, v, _) = make(), states()
    y = problem.eliminated(0.3, x, v)
    along = np.stack([1.0 + 0.0 * x[0], -2.0 + 0.0 * x[0]])
    step = problem.eliminated(0.3, x + 1e-100j * along, v).imag / 1e-100
    found = problem.linearised_constraint(0.3, x, v, y)

    assert np.abs(constraint(0.3, x, v, y)).max() <= 32 * EPS
    expected = -np.einsum("qdP,dP->qP", found.x, along) / found.y[0]
    assert np.abs(step - expected).max() <= 1e-13


def test_y_is_nan_where_the_constraint_has_no_solution() -> None:
    """Elsewhere it is the root near the start."""
    problem = make(constraint=lambda t, x, v, y: y**2 - x[:1], algebraic=[1.0])
    with np.errstate(all="ignore"):
        y = problem.eliminated(0.0, np.array([[4.0, -1.0, 0.25], [0.0, 0.0, 0.0]]), np.zeros((2, 3)))

    assert np.isnan(y[0, 1])
    assert y[0, [0, 2]].tolist() == pytest.approx([2.0, 0.5])


def test_without_y_the_coefficients_are_those_at_the_solved_y() -> None:
    """The view with y eliminated has drift, noise and history of the problem, and nothing algebraic."""
    problem, (x, v, none) = make(), states()
    plain, y = problem.without_y(), problem.eliminated(0.3, x, v)

    assert plain.constraints == 0
    assert not plain.has_constraints
    assert np.array_equal(plain.drift(0.3, x, v, none[:0]), drift(0.3, x, v, y))
    assert np.array_equal(plain.diffusion(0.3, x, v, none[:0]), diffusion(0.3, x, v, y))
    assert plain.without_y() is plain


def test_views_with_and_without_delay() -> None:
    """Only without delay x alone is a state: then there is an equation of x, the same object each time.

    Its growth is known of the view that schemes get, and not looked at where steps are compared with it.
    """
    late, prompt = make(), make(delay=0.0, algebraic=1, history=lambda t: [1.0, 0.5])

    assert late.view(DelaySDAE) is late
    assert late.view(SDE) is None
    assert late.ito() is None
    assert prompt.view(HolonomicSDAE) is None
    equation = prompt.view(SDE)
    assert isinstance(equation, SDE)
    assert equation is prompt.view(SDE)
    assert prompt.ito() is prompt.ito()
    affine = gbm_algebraic()
    assert affine.view(SDE).traits - affine.ito().traits == {"linear-growth"}
    x = states()[0]
    y = prompt.eliminated(0.3, x, x)
    np.testing.assert_allclose(equation.drift(0.3, x), drift(0.3, x, x, y), rtol=1e-13)
    assert prompt.recall(0.1, 3) is None


@pytest.mark.parametrize(
    ("problem", "there", "missing"),
    [
        (make(), {"algebraic", "constrained"}, {"no-delay", "dissipative", "unconstrained"}),
        (make(delay=0.0), {"algebraic", "no-delay"}, {"dissipative"}),
        (delay_ou(), {"unconstrained", "additive-noise"}, {"algebraic", "no-delay", "commutative-noise"}),
        (delay_test("IV"), {"dissipative", "delayed-noise", "algebraic"}, {"no-delay"}),
        (delay_test("II"), {"algebraic"}, {"dissipative", "delayed-noise"}),
        (delay_test("III"), {"algebraic", "dissipative"}, {"delayed-noise"}),
        (delay_test("III").without_y(), {"dissipative"}, set()),
    ],
)
def test_traits_are_those_of_the_equation(problem: DelaySDAE, there: set[str], missing: set[str]) -> None:
    """The form sets what it knows: y, the delay, and whether condition (4.1) holds."""
    assert there <= problem.traits
    assert not missing & problem.traits


def test_the_residual_needs_the_past() -> None:
    """Without the lagged x or y nothing is said of the constraint; with it, its defect and the size of its terms."""
    problem, (x, v, y) = make(), states(3)
    parts = {"x": x, "y": y}

    assert problem.residuals(parts) == {}
    assert problem.residuals({"x": x, "lagged": v}) == {}
    residual = problem.residuals({**parts, "lagged": v, "t": np.full((1, 1), 0.3)})["u"]
    assert np.array_equal(residual.value, constraint(0.3, x, v, y))
    assert np.all(residual.scale > 0.0)
