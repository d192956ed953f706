"""Projected Euler-Maruyama on curves."""

import numpy as np
import pytest
from scipy.optimize import root

from facade import ProjectedEuler, ellipse
from facade import _circle as circle
from sdaeverify import SDE, Increment

EPS = np.finfo(float).eps
H, PATHS = 0.1, 7


@pytest.mark.parametrize("measure", ["arc", "delta"])
def test_on_an_ellipse_the_point_is_brought_back_along_its_normal(measure: str) -> None:
    """x+ = y + kappa grad g(y) with g(x+) = 0, as another solver finds it."""
    problem, rng = ellipse(measure), np.random.default_rng(5)
    x = problem.admissible(problem.initial(PATHS) + 0.3 * rng.standard_normal((2, PATHS)))
    dW = np.sqrt(H) * rng.standard_normal((1, PATHS))
    y = x + H * problem.drift(0.2, x) + problem.diffusion(0.2, x)[:, 0] * dW

    step = ProjectedEuler().prepare(problem, H)(x, 0.2, Increment(dW, np.full_like(dW, np.nan)))

    for p, (point, gradient) in enumerate(zip(y.T, np.stack([0.25 * y[0], y[1]], axis=1), strict=True)):
        found = root(lambda k, y=point, n=gradient: problem.constraint((y + k * n)[:, None])[:, 0], [0.0], tol=1e-13)
        assert np.abs(step.state[:, p] - point - found.x * gradient).max() <= 1e-11
        assert step.outputs["kappa"][0, p] == pytest.approx(found.x[0], abs=1e-11)
    assert np.abs(problem.constraint(step.state)).max() <= 8 * EPS


def test_a_path_without_root_keeps_its_state() -> None:
    """From the centre of the circle there is no direction: the path is counted and stays where it was."""
    problem = SDE(
        drift=lambda t, x: np.array([[-1.0 / H], [0.0]]) + 0.0 * x,
        diffusion=lambda t, x: np.zeros((2, 1, 1)),
        start=[1.0, 0.0],
        constraint=circle.constraint,
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
