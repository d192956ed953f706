"""The rigid trimer: its angle as a diffusion of its own, and the surface measure."""

import numpy as np
import pytest
from scipy.linalg import expm

from problems.generator import generator, observed
from sdaeverify import InvariantMean, Moment, ParameterError
from sdaeverify.arrays import Array
from sdaeverify.testing.checks.differences import SECOND_ERROR
from sdaeverify_problems._interval_diffusion import IntervalDiffusion
from sdaeverify_problems.rigid_trimer import angle_diffusion, rigid_trimer

CELLS = 800


def rigid(paths: int) -> Array:
    """Return points with two unit bonds in random directions, shape (9, P)."""
    bonds = np.random.default_rng(4).standard_normal((2, 3, paths))
    first, second = bonds / np.linalg.norm(bonds, axis=1, keepdims=True)
    return np.concatenate([0.0 * first, first, first + second])


@pytest.mark.parametrize("power", [1, 2, 3])
def test_the_angle_is_a_diffusion_of_its_own(power: int) -> None:
    """In R^9 the generator of c^n is D (c^n)'' + (D' + D rho'/rho) (c^n)', whatever the bonds' directions."""
    sigma = 0.8
    problem, x = rigid_trimer(sigma=sigma), rigid(30)
    c = observed(problem, "c")(x)
    D = 3.0 * sigma**2 * (1.0 - c**2) / (2.0 - c)
    slope = 3.0 * sigma**2 * (c**2 - 4.0 * c + 1.0) / (2.0 - c) ** 2
    drift = slope - D * c / (4.0 - c**2)
    expected = power * c ** (power - 1) * drift + (power * (power - 1) * c ** max(power - 2, 0)) * D
    image = generator(problem, observed(problem, "c" if power == 1 else f"c^{power}"), x)

    assert np.abs(problem.constraint(x)).max() < 1e-14
    assert np.abs(image - expected).max() <= 10 * SECOND_ERROR * (1.0 + np.abs(image).max())


def test_the_mean_square_is_that_of_the_surface_measure() -> None:
    """E c^2 = (2 pi/3 - sqrt(3)/2)/(2 pi/3 + sqrt(3)) = 0.3210210, and not the 1/3 of uniform bonds."""
    (truth,) = [truth for truth in rigid_trimer().truths if isinstance(truth, InvariantMean)]
    value = (2 * np.pi / 3 - np.sqrt(3) / 2) / (2 * np.pi / 3 + np.sqrt(3))

    assert truth.value == pytest.approx(value, rel=1e-13)
    assert truth.value == pytest.approx(0.3210210, abs=6e-8)
    assert abs(truth.value - 1.0 / 3.0) > 0.01


def by_cells(start: float, t: float) -> dict[str, float]:
    """Return the expectations of c and c^2 by finite volumes that conserve rho, sigma = 1."""
    edges = np.linspace(-1.0, 1.0, CELLS + 1)
    c, width = 0.5 * (edges[1:] + edges[:-1]), 2.0 / CELLS
    rho, flow = np.sqrt(4.0 - c**2), np.sqrt(4.0 - edges**2) * 3.0 * (1.0 - edges**2) / (2.0 - edges)
    up, down = flow[1:] / rho / width**2, flow[:-1] / rho / width**2
    L = np.diag(up[:-1], 1) + np.diag(down[1:], -1) - np.diag(up + down)
    later = expm(t * L) @ np.stack([c, c**2], axis=1)
    return {name: float(np.interp(start, c, column)) for name, column in zip(("c", "c^2"), later.T, strict=True)}


@pytest.mark.parametrize("t", [0.05, 0.25])
def test_moments_are_those_of_finite_volumes(t: float) -> None:
    """Expectations at a time agree with an independent discretisation, whose error is about the width squared."""
    known = {truth.observable: truth.value(t) for truth in rigid_trimer().truths if isinstance(truth, Moment)}
    for name, value in by_cells(float(np.cos(1.2)), t).items():
        assert known[name] == pytest.approx(value, abs=1e-4)


def test_legendre_polynomials_decay_as_they_must() -> None:
    """With rho = 1 and D = (1 - c^2)/2, P_l decays at the rate l (l + 1)/2."""
    c, w = np.polynomial.legendre.leggauss(24)
    diffusion = IntervalDiffusion(c, 0.5 * w, 0.5 * (1.0 - c * c), 12)

    assert diffusion.gap == pytest.approx(1.0, rel=1e-12)
    value = diffusion.expectation(lambda u: 1.5 * u * u - 0.5, 0.3, 0.4)
    assert value == pytest.approx(np.exp(-1.2) * (1.5 * 0.09 - 0.5), rel=1e-12)


def test_the_relaxation_time_is_that_of_the_angle() -> None:
    """It is the reciprocal of the gap, and goes with 1/sigma^2."""
    assert rigid_trimer(sigma=2.0).relaxation == pytest.approx(0.25 / angle_diffusion(1.0).gap, rel=1e-12)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"eps": -1.0}, "eps must be finite and not negative, got -1.0"),
        ({"sigma": 0.0}, "sigma must be positive and finite, got 0.0"),
    ],
)
def test_bad_parameters_are_named(parameters: dict[str, float], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message):
        rigid_trimer(**parameters)
