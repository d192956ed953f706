"""The geometry that the pendulums share."""

import numpy as np

from facade import _circle as circle

EPS = np.finfo(float).eps


def test_constants_are_the_least_bound_of_the_norms_near_the_circle() -> None:
    """C_g bounds all norms of (2.7) on the closed neighbourhood of width eps, and is attained there.

    M = Id, m = 1: the norms of grad g, G = |grad g|^2 and 1/G at x_1, and of D^2 g and D^3 g everywhere; the bilinear
    form D^2 g is largest on equal unit vectors, being symmetric.
    """
    radius = np.linspace(1.0 - circle.EPS, 1.0 + circle.EPS, 81)
    angle = np.linspace(0.0, 2 * np.pi, 73)
    x = (radius[:, None] * circle.normal(angle)[:, None]).reshape(2, -1)
    gradient = np.linalg.norm(circle.jacobian(x)[0], axis=0)
    everywhere = np.random.default_rng(1).standard_normal((2, 500)) * 10.0
    unit = circle.normal(np.linspace(0.0, 2 * np.pi, 500))
    curvature = np.abs(circle.curvature(everywhere, unit, unit)[0])
    third = circle.curvature(everywhere + 1.0, unit, unit) - circle.curvature(everywhere, unit, unit)

    norms = [gradient.max(), (gradient**2).max(), (gradient**-2).max(), curvature.max(), np.abs(third).max()]

    assert max(norms) <= circle.CONSTRAINT_BOUND * (1 + 8 * EPS)
    assert max(norms) >= circle.CONSTRAINT_BOUND * (1 - 8 * EPS)
    assert circle.CONSTRAINT_BOUND >= 1.0
