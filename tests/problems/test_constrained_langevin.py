"""Constrained Langevin dynamics for any mass matrix and friction: balance, invariant law, constants and refusals."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import dblquad

from facade import _unit_sphere as unit_sphere
from problems.tangent_law import Law, canonical_nodes, images, monomials
from sdaeverify import Array, HolonomicSDAE, ParameterError, ProblemError
from sdaeverify.numerics import product_transposed
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


def langevin(bath: Bath, mass: Any = MASS, **more: Any) -> HolonomicSDAE:
    """Return the dynamics on the sphere."""
    return constrained_langevin(
        gradient,
        bath,
        constraint=unit_sphere.constraint,
        mass=mass,
        position=[0.6, 0.0, -0.8],
        velocity=[0.0, 0.5, 0.0],
        horizon=1.0,
        **more,
    )


def points(count: int = 20) -> Array:
    r = np.random.default_rng(1).standard_normal((3, count))
    return r / np.linalg.norm(r, axis=0)


@pytest.mark.parametrize("name", BATHS)
def test_noise_and_friction_are_in_balance(name: str) -> None:
    """Sigma sigma^T = 2 kT gamma at every position, gamma being what the force takes away from v."""
    problem, r, v = langevin(BATHS[name]), points(), points()[::-1]
    sigma = np.broadcast_to(problem.diffusion(0.0, r, v), (3, problem.noise_dim, 20))
    drag = problem.force(0.0, r, 0.0 * v) - problem.force(0.0, r, v)

    balance = np.einsum("ijp,jp->ip", product_transposed(sigma, sigma), v)

    assert np.abs(balance - 2.0 * KT * drag).max() <= 32 * EPS
    assert np.abs(problem.force(0.0, r, 0.0 * v) + gradient(r)).max() == 0.0


@pytest.fixture(scope="module")
def law() -> Law:
    return canonical_nodes(MASS, KT, potential)


def drift_of_means(problem: HolonomicSDAE, law: Law) -> float:
    """Return the largest mean of L q over monomials, in units of what rounding can do to it."""
    image = images(problem, law.x, monomials(1, 2))
    # Each value is made up of some thirty products, whose inputs have been solved for and projected.
    return float(np.max(np.abs(image.values @ law.weights) / (64 * EPS * (image.sizes @ law.weights + EPS))))


@pytest.mark.parametrize("name", BATHS)
def test_the_invariant_law_does_not_depend_on_friction(law: Law, name: str) -> None:
    """Under the law with the factor sqrt(r^T M^{-1} r), means of monomials of degree (1, 2) stay as they are."""
    assert drift_of_means(langevin(BATHS[name]), law) <= 1.0


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
    ends = np.linalg.eigh(mass)[1]
    x = np.concatenate([(1.0 + s) * np.concatenate([ends, points(200)], axis=1) for s in (-eps, 0.0, eps)], axis=1)
    gram = np.einsum("ip,ij,jp->p", x, inverse, x)
    norms = np.concatenate([np.linalg.norm(inverse @ x, axis=0), gram, 1.0 / gram, [1.0]])

    bound = unit_sphere.constraint_bound(mass, eps)

    assert norms.max() == pytest.approx(bound, rel=16 * EPS)


BAD: dict[str, tuple[dict[str, Any], type[Exception], str]] = {
    "no friction": ({"friction": 0.0}, ParameterError, "friction must be a positive number"),
    "negative friction": ({"friction": -1.0}, ParameterError, "friction must be a positive number"),
    "no number": ({"friction": float("nan")}, ParameterError, "friction must be a positive number"),
    "not symmetric": ({"friction": MATRIX + np.eye(3, k=1)}, ParameterError, "symmetric positive definite"),
    "not definite": ({"friction": np.diag([1.0, 1.0, -0.1])}, ParameterError, "symmetric positive definite"),
    "negative at the start": ({"friction": lambda r: r[2]}, ParameterError, "friction must be a positive number"),
    "wrong size": ({"friction": np.eye(2)}, ParameterError, r"of shape \(3, 3\)"),
    "no temperature": ({"kT": 0.0}, ParameterError, "temperature kT must be positive"),
    "infinite temperature": ({"kT": float("inf")}, ParameterError, "temperature kT must be positive"),
    "no balance": ({"noise": lambda r: np.eye(3)[..., None]}, ProblemError, "must be 2 kT gamma"),
}


@pytest.mark.parametrize("fault", BAD)
def test_a_bath_that_makes_no_sense_is_refused(fault: str) -> None:
    """Friction, temperature and noise that cannot be are refused in one line that says what was given."""
    fields, error, message = BAD[fault]

    with pytest.raises(error, match=message) as caught:
        langevin(Bath(**{"friction": 0.9, "kT": KT, **fields}))

    assert "\n" not in str(caught.value)


def test_a_singular_mass_matrix_is_refused() -> None:
    """The line names the eigenvalues."""
    with pytest.raises(ProblemError, match="mass must be positive definite beyond rounding, its eigenvalues are"):
        langevin(BATHS["number"], mass=np.diag([1.0, 1.0, 0.0]))


def test_a_start_or_a_gradient_that_is_not_there_is_refused() -> None:
    """What is missing is one line."""
    bath = Bath(friction=0.9, kT=KT)
    with pytest.raises(ProblemError, match=r"^constrained Langevin dynamics need the position they start from$"):
        constrained_langevin(lambda r: r, bath)
    with pytest.raises(ProblemError, match=r"^grad V returned shape \(1,\) for positions of shape \(3, 1\)$"):
        constrained_langevin(lambda r: r[0], bath, position=[1.0, 0.0, 0.0])
