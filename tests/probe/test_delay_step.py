"""One delayed step as a recursion and as a queue, against the recursion of the formula sheet written out."""

import numpy as np
import pytest

from facade import LinearDelayStep, as_recursion
from probe.delay_queue import queue_operator
from probe.theta_cells import MESHES, SETS, companion, random_step, walked
from sdaeverify import Array, Mesh


def sizes(F: Array, count: int) -> Array:
    return np.sort(np.abs(np.linalg.eigvals(F)))[::-1][:count]


@pytest.mark.parametrize("mesh", [mesh for mesh in MESHES if mesh.m > 0])
def test_both_are_the_recursion_written_out(mesh: Mesh) -> None:
    """Without noise, with interpolated lagged values and with a lag shorter than a step."""
    m, delta = mesh
    rng = np.random.default_rng(0)
    step = random_step(rng, 1, 1, 1)
    x = rng.standard_normal(m + 1)
    expected = walked(step, mesh, x, 12)

    past = np.array(x[::-1])
    recursion = as_recursion(step, mesh)
    F, found = companion(recursion), [past[0]]
    past = past[: len(F)] if len(F) < len(past) else past
    for _ in range(12):
        past = F @ past
        found.append(past[0])
    assert found == pytest.approx(expected, rel=1e-13)

    lags = [delta * x[j + 1] + (1.0 - delta) * x[j] for j in range(m)]
    queue, found = np.array([x[-1], *lags]), [x[-1]]
    for _ in range(12):
        queue = queue_operator(step, mesh).factors[..., 0] @ queue
        found.append(queue[0])
    assert found == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d"), [(1, 1), (2, 1), (3, 2)])
def test_recursion_and_queue_have_the_same_eigenvalues(mesh: Mesh, k: int, d: int) -> None:
    """All that are not 0 of the smaller matrix, with algebraic components, too."""
    step = random_step(np.random.default_rng(1), k, d, 2)
    F, queue = companion(as_recursion(step, mesh)), queue_operator(step, mesh).factors[..., 0]
    count = k + max(0, mesh.m - 1) * d
    assert sizes(F, count) == pytest.approx(sizes(queue, count), rel=1e-6)


@pytest.mark.parametrize("mesh", MESHES)
def test_noise_reads_the_same_lagged_values(mesh: Mesh) -> None:
    """Noise with the drift's coefficients has the drift's recursion, and the drift's rows of the queue."""
    step = random_step(np.random.default_rng(2), 3, 2, 1)
    doubled = LinearDelayStep(step.drift, 2.0 * step.drift[None])
    drift, noise = as_recursion(doubled, mesh).maps
    assert noise == pytest.approx(2.0 * drift)

    factors = queue_operator(doubled, mesh).factors
    assert factors[:3, :, 1] == pytest.approx(2.0 * factors[:3, :, 0])
    # Of the lagged values only the newest one has noise, delta times that of x.
    assert factors[3:-2, :, 1] == pytest.approx(0.0)
    if mesh.m > 0:
        assert factors[-2:, :, 1] == pytest.approx(mesh.delta * factors[:2, :, 1])


def test_at_most_four_lags_have_coefficients() -> None:
    """However long the delay: those of y_n, v_n and v_{n+1}."""
    step = SETS["VI"].step(0.3, 1.0 / 99.5)
    assert as_recursion(step, SETS["VI"].mesh(1.0 / 99.5)).lags.tolist() == [0, 98, 99, 100]
    assert as_recursion(step, Mesh(1, 0.5)).lags.tolist() == [0, 1]
