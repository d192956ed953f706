"""Constrained problems that no closed form fits: a full mass matrix, forces and noise that depend on everything."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from sdaeverify import Array, HolonomicSDAE, HolonomicState


class Body(NamedTuple):
    """A problem, its formulas written out for one path, and states on its manifold."""

    problem: HolonomicSDAE
    constraint: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]
    curvature: Callable[[Array, Array], Array]
    mass: Array
    state: HolonomicState


def definite(n: int) -> Array:
    """Return a positive definite matrix without structure."""
    A = np.random.default_rng(n).standard_normal((n, n))
    return np.eye(n) + A @ A.T / n


def force(t: float, r: Array, v: Array) -> Array:
    return np.sin(2.0 * r[::-1]) - 0.4 * v + t * v[::-1] ** 2


def diffusion(t: float, r: Array, v: Array) -> Array:
    return (1.0 + 0.5 * t) * np.stack([0.5 + 0.3 * r, 0.2 * v + np.cos(r[::-1])], axis=1)


def velocities(problem: HolonomicSDAE, r: Array) -> Array:
    """Return random tangent vectors."""
    v = np.random.default_rng(7).standard_normal(r.shape)
    for p in range(r.shape[1]):
        Dg = problem.dg(r[:, p : p + 1])[..., 0]
        v[:, p] -= np.linalg.pinv(Dg) @ (Dg @ v[:, p])
    return v


def sphere_constraint(r: Array) -> Array:
    return 0.5 * (1.0 - (r * r).sum(axis=0))[None]


def rods_constraint(r: Array) -> Array:
    first, second = r[:2], r[2:] - r[:2]
    return 0.5 * np.stack([1.0 - (first * first).sum(axis=0), 0.25 - (second * second).sum(axis=0)])


def make(
    constraint: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    curvature: Callable[[Array, Array], Array],
    r: Array,
) -> Body:
    n = len(r)
    mass = definite(n)
    start = r[:, 0] * 1.0
    problem = HolonomicSDAE(
        force=force,
        diffusion=diffusion,
        constraint=constraint,
        position=start,
        velocity=np.zeros(n),
        mass=mass,
        horizon=1.0,
        noise_dim=2,
        source="made up",
    )
    multiplier = np.zeros((problem.constraints, r.shape[1]))
    state = HolonomicState(r, velocities(problem, r), multiplier)
    return Body(problem, constraint, jacobian, curvature, mass, state)


@pytest.fixture
def sphere() -> Body:
    """Return a point on the unit sphere in R^3, on six paths."""
    r = np.random.default_rng(3).standard_normal((3, 6))
    return make(
        sphere_constraint,
        lambda r: -r[None],
        lambda y, z: -np.array([y @ z]),
        r / np.linalg.norm(r, axis=0),
    )


@pytest.fixture
def rods() -> Body:
    """Return two points on rods of lengths 1 and 1/2 in the plane, hung at the origin, on six paths."""
    first, second = np.random.default_rng(4).uniform(-3.0, 3.0, (2, 6))
    r = np.stack([np.cos(first), np.sin(first)])
    end = r + 0.5 * np.stack([np.cos(second), np.sin(second)])

    def jacobian(r: Array) -> Array:
        a, d = r[:2], r[2:] - r[:2]
        return -np.array([[a[0], a[1], 0.0, 0.0], [-d[0], -d[1], d[0], d[1]]])

    def curvature(y: Array, z: Array) -> Array:
        return -np.array([y[:2] @ z[:2], (y[2:] - y[:2]) @ (z[2:] - z[:2])])

    return make(rods_constraint, jacobian, curvature, np.concatenate([r, end]))


@pytest.fixture(params=["sphere", "rods"])
def body(request: pytest.FixtureRequest) -> Body:
    found: Body = request.getfixturevalue(request.param)
    return found
