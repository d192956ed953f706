"""The theta methods of delay equations against coupled solves done another way, on every kind of mesh."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq, root

from facade import SETS, LaggedAlgebraicTheta, StochasticTheta, delay_ou, delay_test, gbm, match
from schemes.delay_cells import MESHES, PATHS, H, T, given, nonlinear
from sdaeverify import Array, DelaySDAE, DelayState, Increment, Scheme, Step

THETAS = (0.0, 0.3, 0.5, 1.0)
# Newton's last update is below 1e-9 of the state, its error about the square; the rest is rounding.
CLOSE = 1e-13


def values(problem: DelaySDAE, state: DelayState, noise: Increment, h: float, path: int) -> tuple[Array, ...]:
    """Return x, y, v, dW, the known part of v+ and the weight of x+ in it on one path."""
    x, y, dW = (array[:, path : path + 1] for array in (*state, noise.dW))
    if not problem.delay:
        return x, y, x, dW, 0.0 * x, np.array(1.0)
    m, delta = problem.mesh(h)
    assert noise.lagged is not None
    assert noise.ahead is not None
    weight = delta if m == 1 else 0.0
    return x, y, noise.lagged[:, path : path + 1], dW, noise.ahead[:, path : path + 1], np.array(weight)


def written_out(problem: DelaySDAE, h: float, theta: float, *, old_y: bool) -> Callable[[int], Array]:
    """Return the step of one path by a solver for systems of equations that knows nothing of their structure."""
    state, noise = given(problem, h)

    def solve(path: int) -> Array:
        x, y, v, dW, known, weight = values(problem, state, noise, h, path)
        d = len(x)
        begin = x + h * (1.0 - theta) * problem.drift(T, x, v, y)
        begin = begin + np.einsum("dlP,lP->dP", problem.diffusion(T, x, v, y), dW)

        def defect(z: Array) -> Array:
            new, y_new = z[:d, None], z[d:, None]
            v_new = known + weight * new
            f = problem.drift(T + h, new, v_new, y if old_y else y_new)
            u = problem.constraint(T + h, new, v_new, y_new)
            return np.concatenate([new - begin - h * theta * f, u])[:, 0]

        found = root(defect, np.concatenate([x, y])[:, 0], tol=1e-15)
        assert np.abs(defect(found.x)).max() <= 1e-13
        return np.asarray(found.x)

    return solve


def moved(scheme: Scheme, problem: DelaySDAE, h: float) -> Step:
    state, noise = given(problem, h)
    return scheme.prepare(problem, h)(state, T, noise)


@pytest.mark.parametrize("kind", [StochasticTheta, LaggedAlgebraicTheta])
@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("mesh", MESHES)
def test_a_step_is_the_coupled_solution(kind: type, theta: float, mesh: str) -> None:
    """On every mesh, x and y together solve the equations of the method, found by another solver."""
    problem = nonlinear(MESHES[mesh] * H)
    step = moved(kind(theta), problem, H)
    expected = written_out(problem, H, theta, old_y=kind is LaggedAlgebraicTheta)

    assert step.failed is not None
    assert not step.failed.any()
    for path in range(PATHS):
        np.testing.assert_allclose(np.concatenate(step.state)[:, path], expected(path), rtol=CLOSE, atol=CLOSE)


@pytest.mark.parametrize("theta", THETAS)
def test_a_step_longer_than_the_delay_solves_for_its_own_past(theta: float) -> None:
    """With m = 1 and delta > 0, x+ is the root of one scalar equation, to 1e-13."""
    problem, h, (a, b, c, d, l, q) = delay_test("IV"), 1.0 / 0.6, SETS["IV"]
    state, noise = given(problem, h)
    weight, v = problem.mesh(h).weight, noise.lagged
    assert weight == pytest.approx(0.4)
    got = StochasticTheta(theta).step(problem, state, T, h, noise).state
    for p in range(PATHS):
        x, y, old, known = state.x[0, p], state.y[0, p], v[0, p], noise.ahead[0, p]
        start = x + h * (1.0 - theta) * (a * x + b * old + y) + (c * x + d * old) * noise.dW[0, p]

        def defect(z: float, start: float = start, known: float = known) -> float:
            w = known + weight * z
            return z - start - h * theta * ((a + q) * z + b * w + l * np.sin(w))

        x_new = brentq(defect, -50.0, 50.0, xtol=1e-15, rtol=1e-15)
        y_new = l * np.sin(known + weight * x_new) + q * x_new
        assert got.x[0, p] == pytest.approx(x_new, rel=CLOSE, abs=CLOSE)
        assert got.y[0, p] == pytest.approx(y_new, rel=CLOSE, abs=CLOSE)


def parabola() -> DelaySDAE:
    """Return a problem whose y = sqrt(x) has no value for x < 0."""
    return DelaySDAE(
        drift=lambda t, x, v, y: -3.0 * y,
        diffusion=lambda t, x, v, y: 0.0 * x[:, None] + 1.0,
        constraint=lambda t, x, v, y: y**2 - x,
        algebraic=[1.0],
        delay=0.5,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )


@pytest.mark.parametrize("kind", [StochasticTheta, LaggedAlgebraicTheta])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_a_path_without_root_is_held_and_counted(kind: type, theta: float) -> None:
    """Where the constraint has no solution the path keeps its state and is flagged; the others go on."""
    problem, h = parabola(), 0.125
    state, one = problem.initial(3), np.ones((1, 3))
    noise = Increment(np.array([[0.1, -3.0, 0.2]]), None, lagged=one, ahead=one)
    with np.errstate(all="ignore"):
        step = kind(theta).step(problem, state, 0.0, h, noise)

    assert step.failed is not None
    assert step.failed.tolist() == [False, True, False]
    assert [part[0, 1] for part in step.state] == [1.0, 1.0]
    good = step.state.y[0, [0, 2]] ** 2
    np.testing.assert_allclose(good, step.state.x[0, [0, 2]], rtol=1e-12)
    assert np.all(step.costs["newton_iterations"] >= 1.0)


@pytest.mark.parametrize(
    ("problem", "reason"),
    [(delay_ou(), "no algebraic component: use stochastic-theta"), (gbm(), "solves the form DelaySDAE")],
)
def test_what_the_lagged_method_refuses(problem: DelaySDAE, reason: str) -> None:
    """It is for problems with y, and says which method is for the others."""
    assert reason in match(LaggedAlgebraicTheta(), problem).reason


@pytest.mark.parametrize("kind", [StochasticTheta, LaggedAlgebraicTheta])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_a_constraint_that_turns_over_in_a_step_ends_the_path(kind: type, theta: float) -> None:
    """Where du/dy = 0.7 - t changes its sign the solution has ended, although a step across it has a root."""
    problem = DelaySDAE(
        drift=lambda t, x, v, y: -1.0 * x,
        diffusion=lambda t, x, v, y: 0.1 * x[:, None],
        constraint=lambda t, x, v, y: (0.7 - t) * y - x,
        algebraic=[1.0 / 0.7],
        delay=0.0,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )
    x = np.ones((1, 3))
    noise = Increment(np.zeros((1, 3)), None)
    for t, lost in ((0.5, False), (0.65, True)):
        step = kind(theta=theta).step(problem, DelayState(x, x / (0.7 - t)), t, 0.1, noise)
        assert step.failed is not None
        assert bool(step.failed.all()) is lost


def test_a_drift_that_cannot_be_differentiated_is_refused() -> None:
    """With a delay as without, unless nothing is solved for."""
    problem = DelaySDAE(
        drift=lambda t, x, v, y: -np.abs(x),
        diffusion=lambda t, x, v, y: 0.1 * x[:, None],
        delay=1.0,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=2.0,
        source="made up",
    )
    assert "not analytic" in StochasticTheta(theta=1.0).refuses(problem)
    assert StochasticTheta(theta=0.0).refuses(problem) == ""
