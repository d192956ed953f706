"""Moments along a run against the operator of the whole history, written-out recursions and the equation's own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from facade import Mesh, RunMoments, Start, run_moments
from probe.delay_queue import queue_operator
from probe.theta_cells import MESHES, SETS, Linear, random_step, walked


def from_history(cell: Linear, theta: float, h: float, steps: int) -> RunMoments:
    """Return the moments from the history x(t) = t + 1."""
    mesh = cell.mesh(h)
    lag = np.minimum(0.0, np.arange(mesh.m) * h - cell.tau) + 1.0
    y = np.array([1.0, cell.l * (1.0 - cell.tau) + cell.q])
    return run_moments(cell.step(theta, h), mesh, Start(y, lag[:, None]), steps)


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d", "noises"), [(1, 1, 1), (2, 1, 1), (3, 2, 2)])
def test_moments_are_those_of_the_operator_on_the_whole_history(mesh: Mesh, k: int, d: int, noises: int) -> None:
    """Means and second moments after every one of 25 steps, longer than any of the delays."""
    rng = np.random.default_rng(8)
    step = random_step(rng, k, d, noises)
    start = Start(rng.standard_normal(k), rng.standard_normal((mesh.m, d)))
    found, operator = run_moments(step, mesh, start, 25), queue_operator(step, mesh)
    known = np.concatenate([start.y, start.lagged.ravel()])
    P, scale = np.outer(known, known), 1.0
    for n in range(26):
        scale = max(scale, np.abs(P).max())
        assert found.second[n] == pytest.approx(P[:k, :k], abs=1e-13 * scale)
        assert found.mean[n] == pytest.approx(known[:k], abs=1e-13 * scale)
        P, known = operator(P), operator.factors[..., 0] @ known


@pytest.mark.parametrize("mesh", [Mesh(6, 0.0), Mesh(6, 0.4), Mesh(50_000, 0.3)])
def test_a_run_shorter_than_the_delay_needs_no_later_values(mesh: Mesh) -> None:
    """Three steps use v_0, ..., v_3, and have the moments of the recursion; a table of all values has 20 GB."""
    rng = np.random.default_rng(10)
    step, lagged = random_step(rng, 1, 1, 1), rng.standard_normal((4, 1))
    found = run_moments(step, mesh, Start(np.ones(1), lagged), 3)

    whole = Start(np.ones(1), np.concatenate([lagged, rng.standard_normal((8, 1))]))
    expected = run_moments(step, Mesh(12, mesh.delta), whole, 3)
    assert found.second == pytest.approx(expected.second, abs=1e-13)
    assert found.mean == pytest.approx(expected.mean, abs=1e-13)


@pytest.mark.parametrize("mesh", [mesh for mesh in MESHES if mesh.m > 0])
def test_means_are_the_recursion_written_out(mesh: Mesh) -> None:
    """One component, from a history on the mesh."""
    rng = np.random.default_rng(9)
    step, x = random_step(rng, 1, 1, 1), rng.standard_normal(mesh.m + 1)
    start = Start(x[-1:], (mesh.delta * x[1:] + (1.0 - mesh.delta) * x[:-1])[:, None])
    found = run_moments(step, mesh, start, 15).mean[:, 0]
    assert found == pytest.approx(np.array(walked(step, mesh, x, 15)), abs=1e-13)


@pytest.mark.parametrize(("theta", "order"), [(0.5, 2.0), (1.0, 1.0)])
def test_moments_tend_to_those_of_the_equation(theta: float, order: float) -> None:
    """On [0, 1] E x and E x^2 of set VI obey ordinary equations; means of the trapezoidal rule are of order 2."""
    cell = SETS["VI"]._replace(l=0.0)
    A, (_, b, c, d, *_) = cell.a + cell.q, cell

    def rates(t: float, z: np.ndarray) -> list[float]:
        return [A * z[0] + b * t, (2.0 * A + c * c) * z[1] + 2.0 * (b + c * d) * t * z[0] + (d * t) ** 2]

    exact = solve_ivp(rates, (0.0, 1.0), [1.0, 1.0], rtol=1e-11, atol=1e-13).y[:, -1]
    runs = [from_history(cell, theta, 1.0 / steps, steps) for steps in (50, 100)]
    means, squares = (np.array([run.mean[-1, 0] for run in runs]), np.array([run.second[-1, 0, 0] for run in runs]))

    assert np.log2(np.abs(means - exact[0])[0] / np.abs(means - exact[0])[1]) == pytest.approx(order, abs=0.1)
    assert np.log2(np.abs(squares - exact[1])[0] / np.abs(squares - exact[1])[1]) == pytest.approx(1.0, abs=0.1)
