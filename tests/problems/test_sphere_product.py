"""Products of spheres: mixed constraints leave each point as it would be alone."""

import numpy as np
import pytest

from facade import penalised_sphere, sphere_product


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
