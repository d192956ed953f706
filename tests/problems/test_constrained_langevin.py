"""Constrained Langevin dynamics for any mass matrix and friction: its invariant law and its constants."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import dblquad

from facade import _circle as circle
from facade import _unit_sphere as unit_sphere
from problems.generator import generator
from sdaeverify import SDE, Array, HolonomicSDAE, ParameterError
from sdaeverify.testing.checks.differences import SECOND_ERROR
from sdaeverify_problems.langevin._bath import Bath
from sdaeverify_problems.langevin._canonical_law import Canonical, circle_nodes, invariant_means, sphere_nodes
from sdaeverify_problems.langevin._constrained_langevin import constrained_langevin

EPS = np.finfo(float).eps
KT = 0.7
# Without structure, of eigenvalues 0.80, 1.69 and 3.51.
MASS = np.array([[2.0, 0.6, -0.5], [0.6, 1.5, 0.8], [-0.5, 0.8, 2.5]])
MATRIX = np.array([[1.0, 0.3, 0.2], [0.3, 0.8, -0.1], [0.2, -0.1, 0.6]])


def potential(r: Array) -> Array:
    return 0.6 * r[2] + 0.4 * r[0] * r[1]


def gradient(r: Array) -> Array:
    return np.stack([0.4 * r[1], 0.4 * r[0], np.full_like(r[0], 0.6)])


def rough(r: Array) -> Array:
    """Return a friction matrix that depends on the position, shape (3, 3, P)."""
    return MATRIX[..., None] + 0.3 * r[:, None] * r[None]


def wide(r: Array) -> Array:
    """Return a root of 2 kT `rough` with four columns."""
    constant = np.broadcast_to(np.linalg.cholesky(MATRIX)[..., None], (3, 3, r.shape[1]))
    return np.sqrt(2.0 * KT) * np.concatenate([constant, np.sqrt(0.3) * r[:, None]], axis=1)


BATHS: dict[str, Bath] = {
    "number": Bath(friction=0.9, kT=KT),
    "matrix": Bath(friction=MATRIX, kT=KT),
    "number at a position": Bath(friction=lambda r: 0.5 + r[0] ** 2, kT=KT),
    "matrix at a position": Bath(friction=rough, kT=KT),
    "noise of its own": Bath(friction=rough, kT=KT, noise=wide),
}


def langevin(bath: Bath) -> HolonomicSDAE:
    """Return the dynamics on the sphere."""
    return constrained_langevin(
        gradient,
        bath,
        constraint=unit_sphere.constraint,
        mass=MASS,
        position=[0.6, 0.0, -0.8],
        velocity=[0.0, 0.5, 0.0],
        horizon=1.0,
    )


class Law(NamedTuple):
    """Nodes (r, v), shape (6, P), and weights, shape (P,), of a probability measure."""

    x: Array
    weights: Array


def canonical_nodes(mass: Array, kT: float, potential: Callable[[Array], Array], count: int = 20) -> Law:
    """Return nodes of exp(-V/kT) sqrt(r^T M^{-1} r) on the sphere, velocities being normal.

    In a basis T of the tangent plane, v = T s and s ~ N(0, kT (T^T M T)^{-1}). Gauss' rules have `count` nodes in r_3
    and 5 in each component of s, the trapezoidal rule 2 `count` in the longitude.
    """
    z, weights = np.polynomial.legendre.leggauss(count)
    phi = 2 * np.pi * np.arange(2 * count) / (2 * count)
    rho = np.sqrt(1.0 - z**2)
    r = np.stack([np.outer(rho, np.cos(phi)), np.outer(rho, np.sin(phi)), np.outer(z, np.ones(2 * count))]).reshape(
        3, -1
    )
    first = np.cross(r, np.where(np.abs(r[2]) < 0.9, [[0.0], [0.0], [1.0]], [[1.0], [0.0], [0.0]]), axis=0)
    first = first / np.linalg.norm(first, axis=0)
    T = np.stack([first, np.cross(r, first, axis=0)], axis=1)
    K = np.einsum("iap,ij,jbp->pab", T, mass, T)
    root = np.linalg.cholesky(kT * np.linalg.inv(K))
    nodes, normal = np.polynomial.hermite_e.hermegauss(5)
    s = np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1)
    v = np.einsum("iap,pab,bq->ipq", T, root, s)
    pushed = np.linalg.solve(mass, r)
    density = np.repeat(weights, 2 * count) * np.sqrt((r * pushed).sum(axis=0)) * np.exp(-potential(r) / kT)
    full = np.outer(density, np.outer(normal, normal)).ravel()
    x = np.concatenate([np.broadcast_to(r[..., None], v.shape), v]).reshape(6, -1)
    return Law(x, full / full.sum())


MONOMIALS = {
    "r_1": lambda x: x[0],
    "r_3": lambda x: x[2],
    "v_1": lambda x: x[3],
    "v_3": lambda x: x[5],
    "r_1 v_2": lambda x: x[0] * x[4],
    "r_3 v_3": lambda x: x[2] * x[5],
    "v_1^2": lambda x: x[3] ** 2,
    "v_2 v_3": lambda x: x[4] * x[5],
    "r_3 v_3^2": lambda x: x[2] * x[5] ** 2,
}


@pytest.mark.sweep
@pytest.mark.parametrize("name", BATHS)
def test_the_invariant_law_does_not_depend_on_friction(name: str) -> None:
    """Under the law with the factor sqrt(r^T M^{-1} r), means of L q vanish for monomials q."""
    law, problem = canonical_nodes(MASS, KT, potential), langevin(BATHS[name])
    for monomial, q in MONOMIALS.items():
        image = generator(problem.view(SDE), q, law.x)
        assert abs(image @ law.weights) <= 16 * SECOND_ERROR * (1.0 + np.abs(image) @ law.weights), monomial


def test_means_on_the_sphere_agree_with_adaptive_quadrature() -> None:
    """E r_3, E r_3^2 and E r_1^2 are quotients of double integrals over longitude and latitude, M = diag(1, 2, 4)."""

    def integral(q: Callable[[float, float, float], float]) -> float:
        def density(phi: float, z: float) -> float:
            x, y = np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi)
            return float(q(x, y, z) * np.exp(-z / 0.5) * np.sqrt(x * x + y * y / 2.0 + z * z / 4.0))

        return float(dblquad(density, -1.0, 1.0, 0.0, 2 * np.pi, epsabs=1e-10, epsrel=1e-10)[0])

    law = Canonical(lambda x: x[2], np.diag([1.0, 2.0, 4.0]), 0.5)
    known = {t.observable: t.value for t in invariant_means(law, sphere_nodes, ("r_3", "r_3^2", "r_1^2"))}

    total = integral(lambda x, y, z: 1.0)
    assert known["r_3"] == pytest.approx(integral(lambda x, y, z: z) / total, abs=1e-9)
    assert known["r_3^2"] == pytest.approx(integral(lambda x, y, z: z * z) / total, abs=1e-9)
    assert known["r_1^2"] == pytest.approx(integral(lambda x, y, z: x * x) / total, abs=1e-9)


def test_a_law_that_is_too_narrow_is_refused() -> None:
    """Where the finest nodes do not resolve the law, no mean is given."""
    with pytest.raises(ParameterError, match=r"too narrow for \d+ nodes with kT = 1e-09"):
        invariant_means(Canonical(lambda x: x[1], np.eye(2), 1e-9), circle_nodes, ("r_2",))


@pytest.mark.parametrize("mass", [np.eye(3), MASS, np.diag([0.2, 1.0, 0.5])])
def test_the_bound_of_the_sphere_is_the_largest_of_its_norms(mass: Array) -> None:
    """C_g is no less than any of the norms in (2.7) on the neighbourhood, and is one of them, or 1."""
    eps, inverse = 0.2, np.linalg.inv(mass)
    r = np.random.default_rng(1).standard_normal((3, 200))
    r = np.concatenate([np.linalg.eigh(mass)[1], r / np.linalg.norm(r, axis=0)], axis=1)
    x = np.concatenate([(1.0 + s) * r for s in (-eps, 0.0, eps)], axis=1)
    gram = np.einsum("ip,ij,jp->p", x, inverse, x)
    norms = np.concatenate([np.linalg.norm(inverse @ x, axis=0), gram, 1.0 / gram, [1.0]])

    assert norms.max() == pytest.approx(unit_sphere.constraint_bound(mass, eps), rel=16 * EPS)
    assert unit_sphere.constraint_bound(np.eye(2), circle.EPS) == pytest.approx(circle.CONSTRAINT_BOUND, rel=4 * EPS)
