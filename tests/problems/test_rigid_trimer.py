"""The rigid trimer: its angle as a diffusion of its own, and the surface measure."""

import numpy as np
import pytest
from scipy.linalg import expm

from sdaeverify import InvariantMean, Moment
from sdaeverify_problems.rigid_trimer import angle_diffusion, rigid_trimer

CELLS = 400


def test_the_mean_square_is_that_of_the_surface_measure() -> None:
    """E c^2 = (2 pi/3 - sqrt(3)/2)/(2 pi/3 + sqrt(3)), and not the 1/3 of uniform bonds."""
    (truth,) = [truth for truth in rigid_trimer().truths if isinstance(truth, InvariantMean)]
    value = (2 * np.pi / 3 - np.sqrt(3) / 2) / (2 * np.pi / 3 + np.sqrt(3))

    assert truth.value == pytest.approx(value, rel=1e-13)


def by_cells(start: float, t: float) -> dict[str, float]:
    """Return the expectations of c and c^2 by finite volumes that conserve rho, sigma = 1."""
    edges = np.linspace(-1.0, 1.0, CELLS + 1)
    c, width = 0.5 * (edges[1:] + edges[:-1]), 2.0 / CELLS
    rho, flow = np.sqrt(4.0 - c**2), np.sqrt(4.0 - edges**2) * 3.0 * (1.0 - edges**2) / (2.0 - edges)
    up, down = flow[1:] / rho / width**2, flow[:-1] / rho / width**2
    L = np.diag(up[:-1], 1) + np.diag(down[1:], -1) - np.diag(up + down)
    later = expm(t * L) @ np.stack([c, c**2], axis=1)
    return {name: float(np.interp(start, c, column)) for name, column in zip(("c", "c^2"), later.T, strict=True)}


def test_moments_are_those_of_finite_volumes() -> None:
    """Expectations at a time agree with another discretisation, whose error is about the width squared, 3e-5."""
    t = 0.25
    known = {truth.observable: truth.value(t) for truth in rigid_trimer().truths if isinstance(truth, Moment)}
    for name, value in by_cells(float(np.cos(1.2)), t).items():
        assert known[name] == pytest.approx(value, abs=1e-4)


def test_the_relaxation_time_is_that_of_the_angle() -> None:
    """It is the reciprocal of the gap, and goes with 1/sigma^2."""
    assert rigid_trimer(sigma=2.0).relaxation_time == pytest.approx(0.25 / angle_diffusion(1.0).gap, rel=1e-12)
