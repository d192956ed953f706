"""The theta methods of delay equations against coupled solves done another way, on every kind of mesh."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import root

from facade import LaggedAlgebraicTheta, StochasticTheta, delay_ou, gbm, match
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


@pytest.mark.sweep
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


def scalar(**functions: object) -> DelaySDAE:
    """Return a problem of one component without noise to speak of."""
    noise = {"diffusion": lambda t, x, v, y: 0.0 * x[:, None] + 1.0, "noise_dim": 1}
    return DelaySDAE(**{**noise, "history": lambda t: [1.0], "horizon": 2.0, "source": "made up", **functions})


@pytest.mark.parametrize("kind", [StochasticTheta, LaggedAlgebraicTheta])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_a_path_without_root_is_held_and_counted(kind: type, theta: float) -> None:
    """Where y = sqrt(x) has no value for x < 0, the path keeps its state and is flagged; the others go on."""
    problem = scalar(
        drift=lambda t, x, v, y: -3.0 * y,
        constraint=lambda t, x, v, y: y**2 - x,
        algebraic=[1.0],
        delay=0.5,
    )
    one = np.ones((1, 3))
    noise = Increment(np.array([[0.1, -3.0, 0.2]]), None, lagged=one, ahead=one)
    with np.errstate(all="ignore"):
        step = kind(theta).step(problem, problem.initial(3), 0.0, 0.125, noise)

    assert step.failed.tolist() == [False, True, False]
    assert [part[0, 1] for part in step.state] == [1.0, 1.0]
    good = step.state.y[0, [0, 2]] ** 2
    np.testing.assert_allclose(good, step.state.x[0, [0, 2]], rtol=1e-12)
    assert np.all(step.costs["newton_iterations"] >= 1.0)


@pytest.mark.parametrize("kind", [StochasticTheta, LaggedAlgebraicTheta])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_a_constraint_that_turns_over_in_a_step_ends_the_path(kind: type, theta: float) -> None:
    """Where du/dy = 0.7 - t changes its sign the solution has ended, although a step across it has a root."""
    problem = scalar(
        drift=lambda t, x, v, y: -1.0 * x,
        constraint=lambda t, x, v, y: (0.7 - t) * y - x,
        algebraic=[1.0 / 0.7],
        delay=0.0,
    )
    x, noise = np.ones((1, 3)), Increment(np.zeros((1, 3)), None)
    for t, lost in ((0.5, False), (0.65, True)):
        step = kind(theta=theta).step(problem, DelayState(x, x / (0.7 - t)), t, 0.1, noise)
        assert step.failed.tolist() == [lost] * 3


def test_what_a_method_refuses() -> None:
    """One is for problems with y, and says which method is for the others; derivatives must be there if needed."""
    for problem, reason in (
        (delay_ou(), "no algebraic component: use stochastic-theta"),
        (gbm(), "needs a DelaySDAE"),
    ):
        assert reason in match(LaggedAlgebraicTheta(), problem).reason
    kinked = scalar(drift=lambda t, x, v, y: -np.abs(x), delay=1.0)
    assert "not analytic" in StochasticTheta(theta=1.0).refuses(kinked)
    assert StochasticTheta(theta=0.0).refuses(kinked) == ""
