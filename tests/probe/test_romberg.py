"""Extrapolated trees of Euler steps against exact semigroups."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from probe.weak_cells import PROBLEMS, SIGMA, A, B, equation
from sdaeverify.probe.local.romberg import Romberg, depth, leaves, weights

X = np.array([[1.0, 0.4, -0.7]])


def powers(x):
    return np.stack([x[0], x[0] ** 2, x[0] ** 3])


def gbm_moments(h):
    return np.stack([X[0] ** n * np.exp((n * A + 0.5 * n * (n - 1) * B * B) * h) for n in (1, 2, 3)])


def ou_moments(h):
    m, v = np.exp(-h) * X[0], -(SIGMA**2) * np.expm1(-2.0 * h) / 2.0
    return np.stack([m, m**2 + v, m**3 + 3.0 * m * v])


def local_orders(tree, exact, steps, t=0.0):
    """Return the orders in h of the largest error of each function."""
    errors = np.array([np.abs(tree(X, t, h) - exact(h)).max(axis=1) for h in steps])
    return np.log(errors[:-1] / errors[1:]) / np.log(steps[:-1] / steps[1:])[:, None]


@pytest.mark.parametrize(("name", "exact"), [("gbm", gbm_moments), ("ou", ou_moments)])
@pytest.mark.parametrize("K", [1, 2, 3, 4, 5])
def test_k_trees_are_right_up_to_the_power_k_plus_1(name, exact, K):
    """The error against closed-form moments falls by the power K + 1, and by no neighbouring one."""
    steps = np.array([1 / 16, 1 / 32])
    (orders,) = local_orders(Romberg(PROBLEMS[name], powers, K), exact, steps)
    assert orders == pytest.approx(K + 1, abs=0.35)


def test_weights_extrapolate_to_infinitely_many_steps():
    """They sum to 1, annihilate 1/k ... 1/k^(K-1), and their absolute values sum to 9, 28 and 92."""
    for K, total in ((3, 9.0), (4, 28.3), (5, 91.7)):
        k = np.arange(1.0, K + 1.0)
        sums = [(weights(K) / k**power).sum() for power in range(K)]
        assert sums == pytest.approx([1.0] + [0.0] * (K - 1), abs=1e-12)
        assert np.abs(weights(K)).sum() == pytest.approx(total, abs=0.05)


def test_two_noises_agree_with_the_second_moment_equation():
    """Where noises do not commute, P = E[x x^T] follows the matrix exponential of A P + P A^T + sum B_j P B_j^T."""
    problem, x = PROBLEMS["two noises"], np.array([[1.0], [0.5]])
    drift = problem.drift(0.0, np.eye(2))
    columns = [problem.diffusion(0.0, np.eye(2))[:, j] for j in range(2)]
    generator = np.kron(drift, np.eye(2)) + np.kron(np.eye(2), drift) + sum(np.kron(b, b) for b in columns)
    tree = Romberg(problem, lambda y: np.stack([y[0] * y[0], y[0] * y[1], y[1] * y[1]]), depth(2))
    errors = []
    for h in (1 / 8, 1 / 16):
        exact = expm(h * generator) @ np.outer(x, x).ravel()
        errors.append(np.abs(tree(x, 0.0, h)[:, 0] - exact[[0, 1, 3]]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(6.0, abs=0.15)


def test_coefficients_are_taken_at_the_times_of_the_substeps():
    """With a drift that depends on time the order is kept; frozen at the start of the step it is lost."""
    moving = equation(lambda t, x: np.sin(3.0 * t) - x, lambda t, x: np.full((1, 1, 1), SIGMA), [1.0])
    frozen = replace(moving, drift=lambda t, x: np.sin(0.6) - x)
    t = 0.2

    def exact(h):
        # int_t^{t+h} e^{-(t+h-s)} sin 3s ds
        inner = [np.sin(3.0 * s) - 3.0 * np.cos(3.0 * s) for s in (t, t + h)]
        return np.exp(-h) * X + (inner[1] - np.exp(-h) * inner[0]) / 10.0

    steps = np.array([1 / 16, 1 / 32])
    kept, lost = (local_orders(Romberg(p, lambda x: x, 5), exact, steps, t)[0, 0] for p in (moving, frozen))
    assert kept == pytest.approx(6.0, abs=0.2)
    assert lost == pytest.approx(2.0, abs=0.1)


def test_leaves_have_the_moments_of_euler_steps():
    """All (2 l)^k leaves are there, of each root next to each other, with Euler's mean and covariance."""
    problem, x, h = PROBLEMS["sphere"], np.array([[0.6, 0.0], [0.0, 1.0], [0.8, 0.0]]), 0.01
    tree = leaves(problem, x, 0.0, h, 1).reshape(3, 2, 6)
    assert tree.mean(axis=2) == pytest.approx(x - h * x)
    spread = tree - tree.mean(axis=2, keepdims=True)
    b = problem.diffusion(0.0, x)
    assert np.einsum("isk,jsk->ijs", spread, spread) / 6 == pytest.approx(h * np.einsum("ils,jls->ijs", b, b))
    assert leaves(problem, x, 0.0, h, 3).shape == (3, 2 * 6**3)
