"""Constrained Langevin dynamics for any mass matrix and friction: its invariant law and its constants."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import dblquad

from facade import _circle as circle
from facade import _unit_sphere as unit_sphere
from problems.tangent_law import canonical_nodes, images, monomials
from sdaeverify import Array, HolonomicSDAE, ParameterError
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


@pytest.mark.parametrize("name", BATHS)
def test_the_invariant_law_does_not_depend_on_friction(name: str) -> None:
    """Under the law with the factor sqrt(r^T M^{-1} r), means of L q vanish for monomials q of degree (1, 2)."""
    law, problem = canonical_nodes(MASS, KT, potential), langevin(BATHS[name])
    image = images(problem, law.x, monomials(1, 2))

    # Each value is made up of some thirty products, whose inputs have been solved for and projected.
    rounding = 64 * EPS * (image.sizes @ law.weights + EPS)
    assert np.all(np.abs(image.values @ law.weights) <= rounding)


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
