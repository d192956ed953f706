"""Spectral radii of delayed steps: the operator of the history, published numbers, growth rates as h tends to 0."""

import numpy as np
import pytest

from facade import LinearDelayStep, Mesh, radius, spectral_radius
from probe.delay_queue import queue_operator
from probe.theta_cells import MESHES, SETS, Linear, is_stable, random_step


def found(cell: Linear, theta: float, h: float) -> float:
    """Return the radius, known to a part in 10^11."""
    rho, width = radius(cell.step(theta, h), cell.mesh(h))
    assert width <= 1e-11 * max(1.0, rho)
    return rho


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(("k", "d", "noises"), [(1, 1, 1), (2, 1, 1), (2, 1, 2), (3, 2, 2), (2, 2, 0)])
def test_radii_are_those_of_the_operator_on_the_whole_history(mesh: Mesh, k: int, d: int, noises: int) -> None:
    """Both certificates contain the other radius; the operator has a matrix of (k + m d)(k + m d + 1)/2 rows."""
    step = random_step(np.random.default_rng(7), k, d, noises)
    ours, theirs = radius(step, mesh), spectral_radius(queue_operator(step, mesh))
    assert abs(ours.rho - theirs.rho) <= ours.width + theirs.width
    assert ours.width <= 1e-11
    if np.isfinite(theirs.width):
        assert is_stable(step, mesh) is (theirs.rho < 1.0)


def test_published_radii() -> None:
    """Set II grows; at c = 1.6 the scheme grows, which a thousand paths do not show."""
    assert found(SETS["II"], 0.2, 1.0 / 32.0) == pytest.approx(1.025322, abs=0.5e-6)
    wide = Linear(-1.0, 0.0, 1.6, 0.0)
    assert found(wide, 0.2, 1.0 / 32.0) == pytest.approx(1.0179, abs=0.5e-4)
    assert is_stable(wide.step(0.2, 1.0 / 32.0), wide.mesh(1.0 / 32.0)) is False


@pytest.mark.parametrize("c", [0.5, 1.6])
@pytest.mark.parametrize("h", [1.0 / 32.0, 0.3, 1.5])
def test_without_delay_the_radius_has_a_closed_form(c: float, h: float) -> None:
    """((1 + (1 - theta) h A)^2 + h c^2)/(1 - theta h A)^2, with the lag's mesh or without any."""
    expected = ((1.0 - 0.7 * 2.0 * h) ** 2 + h * c * c) / (1.0 + 0.3 * 2.0 * h) ** 2
    for tau in (0.0, 1.0):
        assert found(Linear(-2.0, 0.0, c, 0.0, tau=tau), 0.3, h) == pytest.approx(expected, rel=1e-12)
    undelayed = Linear(-1.5, -0.5, 0.3 * c, 0.7 * c, tau=0.0)
    assert found(undelayed, 0.3, h) == pytest.approx(expected, rel=1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_growth_per_step_tends_to_that_of_the_equation(name: str, shift: float) -> None:
    """log(r)/h - lam is a multiple of h, up to higher powers, on meshes with an interpolated lag, too."""
    cell = SETS[name]
    rate = cell.equation.growth_rate
    coarse, fine = (np.log(found(cell, 0.2, h)) / h - rate for h in (1.0 / (100.0 - shift), 1.0 / (200.0 - shift)))
    assert abs(fine) < 0.02
    assert coarse / fine == pytest.approx(2.0, abs=0.1)


def test_noise_that_excites_no_growing_mean_is_seen_through() -> None:
    """X grows without noise, the noise acts on and reads a component of its own: the larger of the two radii."""
    step = LinearDelayStep(
        np.array([[1.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.2, 0.0, 0.0]]),
        np.array([[[0.0] * 6, [0.0, 0.3, 0.0, 0.0, 0.0, 0.0]]]),
    )
    assert radius(step, Mesh(3, 0.0)).rho == pytest.approx(1.21, rel=1e-11)
    assert is_stable(step, Mesh(3, 0.0)) is False


def test_a_mean_on_the_unit_circle_decides_nothing_by_itself() -> None:
    """A = -B has the eigenvalue 1: with noise that reads it the step grows, with noise that does not it stays."""
    growing, staying = SETS["II"], Linear(-1.0, 1.0, 1.0, -1.0)._replace(c=0.1, d=-0.1)
    assert is_stable(growing.step(0.2, 0.25), growing.mesh(0.25)) is False
    assert is_stable(staying.step(0.2, 0.25), staying.mesh(0.25)) is None
    assert found(staying, 0.2, 0.25) == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("offset", [-1e-8, 1e-8])
def test_a_part_in_ten_to_the_eighth_beside_the_boundary_is_decided(offset: float) -> None:
    """(1 + h A)^2 + h c^2 = 1 at c^2 = -2 A - h A^2."""
    cell = Linear(-2.0, 0.0, np.sqrt(3.0) * (1.0 + offset), 0.0)
    assert is_stable(cell.step(0.0, 0.25), cell.mesh(0.25)) is (offset < 0.0)


def test_nothing_that_grows_is_0() -> None:
    """A step to 0 has a radius that is only bounded."""
    zero = LinearDelayStep(np.zeros((1, 3)), np.zeros((1, 1, 3)))
    assert radius(zero, Mesh(2, 0.5)).rho < 1e-50
    assert is_stable(zero, Mesh(2, 0.5)) is True


@pytest.mark.parametrize("seed", range(4))
def test_a_defective_radius_is_known_as_far_as_its_width_says(seed: int) -> None:
    """Two equal noisy components, one driving the other, turned: a threefold eigenvalue in one Jordan block."""
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((2, 2)))[0]
    maps = np.array([[[0.5, 0.0], [1.0, 0.5]], [[0.6, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 0.6]]])
    turned = np.pad(turn @ maps @ turn.T, ((0, 0), (0, 0), (0, 2)))
    rho, width = radius(LinearDelayStep(turned[0], turned[1:]), Mesh(2, 0.0))
    assert abs(rho - 0.61) <= width
    assert 1e-8 < width < 1e-3


def test_small_radii_are_found() -> None:
    """A stiff equation without lagged terms, theta = 1: the length of the delay plays no part."""
    cell, h = Linear(-1e6, 0.0, 10.0, 0.0), 1.0 / 64.0
    assert found(cell, 1.0, h) == pytest.approx((1.0 + 100.0 * h) / (1.0 + 1e6 * h) ** 2, rel=1e-11)


def test_a_step_at_a_pole_has_no_radius() -> None:
    """Its coefficients are infinite, and nothing is decided."""
    pole = LinearDelayStep(np.full((1, 3), np.inf), np.zeros((1, 1, 3)))
    assert radius(pole, Mesh(1, 0.0)) == (np.inf, np.inf)
    assert is_stable(pole, Mesh(1, 0.0)) is None


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_random_steps_have_a_radius(seed: int) -> None:
    """Coefficients of all sizes, some of them 0: gains that fall exactly like 1/r, of 1e16 and more, and of 0."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        sizes = np.where(rng.random(6) < 0.7, 3.0, 10.0 ** rng.uniform(-8.0, 8.0, 6)) * (rng.random(6) > 0.35)
        cell, theta = Linear(*(sizes * rng.standard_normal(6)).tolist()), float(rng.choice([0.0, 0.5, 1.0]))
        h = 1.0 / float(rng.choice([rng.integers(1, 12), rng.uniform(0.01, 12.0)]))
        with np.errstate(all="ignore"):
            rho, width = radius(cell.step(theta, h), cell.mesh(h))
        assert rho >= 0.0
        assert width >= 0.0


def test_a_gain_whose_reciprocal_is_rounding_leaves_a_radius() -> None:
    """Noise that is 10^8 times what a stiff step leaves of the state: the gain at the first r is above 10^16."""
    cell = Linear(835621.7977838577, 0.0, -1.0, -1.0, 0.0, 4.14)
    rho, width = radius(cell.step(1.0, 1 / 9), cell.mesh(1 / 9))
    assert width <= 1e-9 * rho
