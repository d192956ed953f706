"""Covariances of a recursion against Lyapunov's equation, gains of noise against sums over the past and a circle."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from probe.theta_cells import MESHES, SETS, companion, random_step
from sdaeverify import Mesh
from sdaeverify.probe.linear.delay_step import Lagged, as_recursion
from sdaeverify.probe.stability.delay_radius import covariances, noise_gain, rescale


def around(recursion: Lagged, r: float, nodes: int = 4096) -> float:
    """Return the mean over |z| = sqrt(r) of |g(z) (z Id - R(z))^-1 w|^2, for one noise w g^T: Parseval's identity."""
    z = np.sqrt(r) * np.exp(2.0j * np.pi * np.arange(nodes) / nodes)
    R, G = (np.tensordot(z[:, None] ** -recursion.lags, each, axes=1) for each in recursion.maps)
    k = R.shape[-1]
    w = np.linalg.svd(recursion.maps[1].swapaxes(0, 1).reshape(k, -1))[0][:, :1]
    driven = np.linalg.solve(z[:, None, None] * np.eye(k) - R, np.tile(w.astype(complex), (nodes, 1, 1)))
    return float(np.mean(np.abs(w.T @ G @ driven) ** 2))


def summed(recursion: Lagged, r: float, terms: int = 400) -> float:
    """Return the spectral radius of Q -> sum_n r^-(n+1) sum_j S_jn Q S_jn^T, as a matrix on all Q."""
    F, k = companion(recursion), recursion.maps.shape[-1]
    G = np.zeros((len(recursion.maps) - 1, k, len(F)))
    for lag, each in zip(recursion.lags, recursion.maps[1:].swapaxes(0, 1), strict=True):
        G[:, :, k * lag : k * (lag + 1)] += each
    response, total = np.eye(len(F), k), 0.0
    for n in range(terms):
        total = total + sum(np.kron(S, S) for S in G @ response) / r ** (n + 1)
        response = F @ response
    return float(np.abs(np.linalg.eigvals(total)).max())


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d"), [(1, 1), (2, 1), (3, 2)])
def test_covariances_solve_lyapunovs_equation(mesh: Mesh, k: int, d: int) -> None:
    """The blocks of P = F P F^T + Q in the first row, and none is wrong by more than is said."""
    recursion = rescale(as_recursion(random_step(np.random.default_rng(5), k, d, 1), mesh), 1.5)
    F = companion(recursion)
    Q = np.diag(np.arange(1.0, k + 1.0))
    gamma, change = covariances(recursion, Q[:, :, None])
    padded = np.zeros_like(F)
    padded[:k, :k] = Q
    P = solve_discrete_lyapunov(F, padded)
    expected = P[:k].reshape(k, -1, k).swapaxes(0, 1)

    assert gamma[: len(expected), ..., 0] == pytest.approx(expected, abs=1e-12 * np.abs(P).max())
    assert change < 1e-13


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d", "noises"), [(1, 1, 1), (2, 1, 1), (3, 2, 2), (2, 2, 3)])
def test_gains_are_the_sums_over_past_impulses(mesh: Mesh, k: int, d: int, noises: int) -> None:
    """Several noises of full rank, with algebraic components and without."""
    recursion = as_recursion(random_step(np.random.default_rng(6), k, d, noises), mesh)
    largest = np.abs(np.linalg.eigvals(companion(recursion))).max()
    r = 1.3 * largest**2
    found = noise_gain(recursion, r)
    assert found.value == pytest.approx(summed(recursion, r), rel=1e-11)
    assert found.error < 1e-12 * found.value


@pytest.mark.parametrize("h", [1.0 / 64.0, 0.23, 0.7, 1.5])
def test_gains_of_one_noise_of_rank_one_are_means_over_a_circle(h: float) -> None:
    """Parseval: sum_n r^-(n+1) (g^T F^n w)^2 for the theta method, where P of the history is never needed."""
    cell = SETS["VI"]
    recursion = as_recursion(cell.step(0.4, h), cell.mesh(h))
    assert noise_gain(recursion, 1.0).value == pytest.approx(around(recursion, 1.0), rel=1e-12)


def test_gains_of_delayed_noise_without_drift() -> None:
    """y_{n+1} = a y_n + s x_{n-m} xi: s^2/(r^m (r - a^2))."""
    recursion = Lagged(np.array([0, 7]), np.array([[[[0.5]], [[0.0]]], [[[0.0]], [[0.3]]]]))
    assert noise_gain(recursion, 0.8).value == pytest.approx(0.09 / (0.8**7 * (0.8 - 0.25)), rel=1e-13)


def test_without_noise_there_is_no_gain() -> None:
    """The gain is exactly 0."""
    recursion = Lagged(np.array([0, 3]), np.array([[[[0.5]], [[0.2]]]]))
    assert noise_gain(recursion, 1.0).value == 0.0
