"""Products of spheres: mixed constraints leave each point as it would be alone."""

from typing import Any

import numpy as np
import pytest

from sdaeverify import Moment, ParameterError
from sdaeverify_problems._radial_law import RadialLaw
from sdaeverify_problems.penalised_sphere import penalised_sphere
from sdaeverify_problems.sphere_product import ANGLES, sphere_product


@pytest.mark.parametrize("spheres", [2, 3])
@pytest.mark.parametrize("eps", [0.0, 0.1])
def test_the_equation_is_that_of_each_point_alone(eps: float, spheres: int) -> None:
    """Drift and diffusion of (1.4) and (1.2) are those of single spheres, whatever the mixture."""
    d, rng = 3, np.random.default_rng(2)
    product, single = sphere_product(eps, d, spheres, 0.4).ito(), penalised_sphere(eps, d, 0.0).ito()
    points = rng.standard_normal((spheres, d, 5))
    points = points / np.linalg.norm(points, axis=1, keepdims=True) * (1.0 if eps == 0.0 else 1.2)
    w = rng.standard_normal((spheres, d, 5))
    drift = np.concatenate([single.drift(0.0, y) for y in points])
    noise = np.concatenate([single.diffused(0.0, y, v) for y, v in zip(points, w, strict=True)])

    x = points.reshape(-1, 5)
    assert np.abs(product.drift(0.0, x) - drift).max() < 1e-12
    assert np.abs(product.diffused(0.0, x, w.reshape(-1, 5)) - noise).max() < 1e-12


@pytest.mark.parametrize("eps", [0.0, 0.05, 1.0])
def test_moments_are_those_of_the_points_and_their_products(eps: float) -> None:
    """First moments of both points and their product follow from the law of one."""
    t, law = 0.3, RadialLaw(eps, 2, 1.0)
    known = {truth.observable: truth.value(t) for truth in sphere_product(eps).truths if isinstance(truth, Moment)}
    first, second = (law.harmonic(1, t) * np.cos(angle) for angle in ANGLES)

    assert known["y1_1"] == pytest.approx(first, rel=1e-14)
    assert known["y2_1"] == pytest.approx(second, rel=1e-14)
    assert known["x_1 of y1 times x_1 of y2"] == pytest.approx(first * second, rel=1e-14)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"eps": -1.0}, "eps must be finite and not negative, got -1.0"),
        ({"spheres": 1}, "d and spheres must be at least 2, got 2 and 1"),
        ({"mixing": float("nan")}, "A must be regular"),
    ],
)
def test_bad_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message):
        sphere_product(**parameters)
