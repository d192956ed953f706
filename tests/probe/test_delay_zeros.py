"""Eigenvalues outside a circle, counted, against the eigenvalues of the companion matrix."""

import numpy as np
import pytest

from probe.theta_cells import MESHES, SETS, companion, random_step
from sdaeverify import Mesh
from sdaeverify.probe.linear.delay_step import Lagged, as_recursion
from sdaeverify.probe.stability.delay_radius import outside


def scalar(*coefficients: float) -> Lagged:
    """Return y_{n+1} = sum_i a_i y_{n-i}."""
    return Lagged(np.arange(len(coefficients)), np.array(coefficients)[None, :, None, None])


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d"), [(1, 1), (2, 1), (3, 2)])
def test_counts_are_those_of_the_companion_matrix(mesh: Mesh, k: int, d: int) -> None:
    """On circles halfway between the moduli of the eigenvalues, conjugate pairs counting twice."""
    recursion = as_recursion(random_step(np.random.default_rng(4), k, d, 1), mesh)
    moduli = np.sort(np.abs(np.linalg.eigvals(companion(recursion))))
    moduli = moduli[moduli > 1e-2]
    apart = np.diff(moduli) > 1e-6
    for circle in 0.5 * (moduli[1:] + moduli[:-1])[apart]:
        assert outside(recursion, circle) == np.count_nonzero(moduli > circle)
    assert outside(recursion, 1.01 * moduli[-1]) == 0
    assert outside(recursion, 0.99 * moduli[0]) == len(moduli)


def test_multiple_eigenvalues_count_as_often() -> None:
    """(z - 0.9)^3 has three of them, on either side of circles a part in 10^4 away."""
    recursion = scalar(2.7, -2.43, 0.729)
    assert outside(recursion, 0.9 * (1.0 - 1e-4)) == 3
    assert outside(recursion, 0.9 * (1.0 + 1e-4)) == 0


@pytest.mark.parametrize("eigenvalue", [0.9, -0.9])
def test_a_circle_through_an_eigenvalue_is_not_decided(eigenvalue: float) -> None:
    """Up to rounding; a part in 10^12 beside it is."""
    recursion = scalar(eigenvalue + 0.2, -0.2 * eigenvalue)
    assert outside(recursion, 0.9) is None
    assert outside(recursion, 0.9 * (1.0 - 1e-12)) == 1
    assert outside(recursion, 0.9 * (1.0 + 1e-12)) == 0


def test_a_pair_beside_the_circle_is_not_missed() -> None:
    """An eigenvalue so close to the circle that no regular grid of 10^4 points would see it turn."""
    z = 0.95 * np.exp(2.0j)
    recursion = scalar(2.0 * z.real, -(abs(z) ** 2))
    assert outside(recursion, 0.95 * (1.0 - 1e-10)) == 2
    assert outside(recursion, 0.95 * (1.0 + 1e-10)) == 0


def test_long_delays_are_counted_at_once() -> None:
    """Set IV at h = 1/1024: none outside the unit circle, one outside e^(s h) for s a little left of the root."""
    cell, h = SETS["IV"], 1.0 / 1024.0
    recursion = as_recursion(cell.step(0.2, h), cell.mesh(h))
    s = cell.equation.rightmost_root.real
    assert outside(recursion, 1.0) == 0
    assert outside(recursion, np.exp((s + 0.01) * h)) == 0
    assert outside(recursion, np.exp((s - 0.01) * h)) == 1


def test_what_is_not_finite_is_not_decided() -> None:
    """A step at a pole has no eigenvalues to count."""
    assert outside(scalar(np.inf, 0.5), 1.0) is None
