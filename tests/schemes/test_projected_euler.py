"""Projected Euler-Maruyama on curves and surfaces, and which directions of projection are right."""

import numpy as np
import pytest
from scipy.optimize import root

from facade import ProjectedEuler, ellipse
from sdaeverify import SDE, Array, Increment, Step
from sdaeverify.numerics import apply

EPS = np.finfo(float).eps
H = 0.1


def euler(problem: SDE, x: Array, dW: Array) -> Array:
    return x + H * problem.drift(0.2, x) + apply(problem.diffusion(0.2, x), dW)


def moved(problem: SDE, paths: int = 7) -> tuple[Array, Array, Step]:
    """Return states on the manifold, their Euler step, and the projected one."""
    rng = np.random.default_rng(5)
    x = problem.admissible(problem.initial(paths) + 0.3 * rng.standard_normal((problem.dimension, paths)))
    dW = np.sqrt(H) * rng.standard_normal((problem.noise_dim, paths))
    step = ProjectedEuler().prepare(problem, H)(x, 0.2, Increment(dW, np.full_like(dW, np.nan)))
    return x, euler(problem, x, dW), step


@pytest.mark.parametrize("measure", ["arc", "delta"])
def test_on_an_ellipse_the_point_is_brought_back_along_its_normal(measure: str) -> None:
    """x+ = y + kappa grad g(y) with g(x+) = 0, as another solver finds it."""
    problem = ellipse(measure)
    _, y, step = moved(problem)

    for p in range(y.shape[1]):
        gradient = np.array([0.25 * y[0, p], y[1, p]])
        found = root(
            lambda k, p=p, n=gradient: problem.constraint((y[:, p] + k * n)[:, None])[:, 0], [0.0], tol=1e-13
        )
        assert np.abs(step.state[:, p] - y[:, p] - found.x * gradient).max() <= 1e-11
        assert step.outputs["kappa"][0, p] == pytest.approx(found.x[0], abs=1e-11)
    assert np.abs(problem.constraint(step.state)).max() <= 8 * EPS


def test_a_path_without_root_keeps_its_state() -> None:
    """From the centre of the circle there is no direction: the path is counted and stays where it was."""
    problem = SDE(
        drift=lambda t, x: np.array([[-1.0 / H], [0.0]]) + 0.0 * x,
        diffusion=lambda t, x: np.zeros((2, 1, 1)),
        start=[1.0, 0.0],
        constraint=lambda x: x[:1] ** 2 + x[1:] ** 2 - 1.0,
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )
    x = np.array([[1.0, 0.0], [0.0, 1.0]])

    with np.errstate(all="ignore"):
        step = ProjectedEuler().step(problem, x, 0.0, H, Increment(np.zeros((1, 2)), None))

    assert step.failed.tolist() == [True, False]
    assert np.array_equal(step.state[:, 0], x[:, 0])
    assert np.abs(step.state[:, 1] - np.array([-1.0, 1.0]) / np.sqrt(2)).max() <= 8 * EPS
