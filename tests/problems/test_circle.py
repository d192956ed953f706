"""The geometry that the pendulums share."""

import numpy as np

from sdaeverify_problems import _circle as circle

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


def test_normal_and_tangent_are_orthonormal_and_turn_into_each_other() -> None:
    """|r| = |t| = 1, <r, t> = 0, dr/dtheta = t, dt/dtheta = -r, and J r = t for the rotation J by a right angle."""
    theta = np.linspace(-4.0, 4.0, 33)
    r, t = circle.normal(theta), circle.tangent(theta)
    turn = np.imag(circle.normal(theta + 1e-100j)) / 1e-100, np.imag(circle.tangent(theta + 1e-100j)) / 1e-100

    assert np.abs((r * r).sum(axis=0) - 1.0).max() <= 4 * EPS
    assert np.abs((t * t).sum(axis=0) - 1.0).max() <= 4 * EPS
    assert np.abs((r * t).sum(axis=0)).max() <= 4 * EPS
    assert np.abs(turn[0] - t).max() <= 4 * EPS
    assert np.abs(turn[1] + r).max() <= 4 * EPS
    assert np.array_equal(np.stack([-r[1], r[0]]), t)


def test_position_and_constraint_agree() -> None:
    """The circle is where g vanishes, and g is positive inside."""
    r = circle.normal(np.linspace(-4.0, 4.0, 33))

    assert np.abs(circle.constraint(r)).max() <= 4 * EPS
    assert np.all(circle.constraint(0.5 * r) > 0.0)
    assert np.all(circle.constraint(2.0 * r) < 0.0)
