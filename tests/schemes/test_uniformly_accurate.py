"""The uniformly accurate step against its printed equations, solved path by path by another solver."""

import numpy as np
import pytest
from scipy.optimize import root

from facade import ConstrainedEuler, UniformlyAccurate
from schemes.rough_constraints import SIGMA, D, drift, langevin, points, rough
from sdaeverify import Array, ConstrainedLangevin, Increment, Step

EPS = float(np.finfo(float).eps)
H = 0.02


def increments(x: Array, h: float = H, seed: int = 3) -> Increment:
    return Increment(np.sqrt(h) * np.random.default_rng(seed).standard_normal(x.shape), None)


def step(scheme: object, problem: ConstrainedLangevin, x: Array, noise: Increment, h: float = H) -> Step:
    return scheme.step(problem, x, 0.0, h, noise)


class Printed:
    """The equations at one point, sums over unit vectors written out."""

    def __init__(self, q: int, x: Array, xi: Array, h: float, eps: float) -> None:
        self.rough, self.x, self.xi, self.h, self.eps = rough(q), x, xi, h, eps
        self.zeta, self.g, self.H = self.rough.zeta(x), self.rough.gradient(x), self.rough.hessians(x)
        self.G = self.g.T @ self.g
        self.P = self.g @ np.linalg.solve(self.G, self.g.T)
        self.f = drift(x[:, None])[:, 0]
        self.e, self.omega, self.omega_2 = np.exp(-h / eps), -np.expm1(-h / eps), -np.expm1(-2.0 * h / eps)

    def turned(self, v: Array) -> Array:
        """Return g'(v), d x q."""
        return np.stack([H_k @ v for H_k in self.H], axis=1)

    @property
    def fixman(self) -> Array:
        """Return grad ln det G = 2 sum_i g'(e_i) G^{-1} g^T e_i, Lemma 3.2."""
        return 2.0 * sum(self.turned(e) @ np.linalg.solve(self.G, self.g.T @ e) for e in np.eye(D))

    @property
    def quadratic(self) -> Array:
        """Return g'(w) c."""
        c = np.linalg.solve(self.G, self.zeta)
        return self.turned(self.g @ c) @ c

    @property
    def level(self) -> Array:
        """Return the second line of (2.2), with the sums that cancel."""
        h, eps, P = self.h, self.eps, self.P
        div = np.array([np.trace(H_k) for H_k in self.H])
        one = sum(self.turned(P @ e).T @ P @ e for e in np.eye(D))
        other = sum(self.turned(e).T @ P @ e for e in np.eye(D))
        spread = SIGMA * np.sqrt(0.5 * eps * self.omega_2) * self.g.T @ self.xi
        drift = self.g.T @ self.f + SIGMA**2 / 4.0 * self.g.T @ self.fixman + SIGMA**2 / 2.0 * div
        vanishing = SIGMA**2 * (eps * self.omega - np.sqrt(0.5 * eps * h * self.omega_2)) * (one - other)
        return self.e * self.zeta + spread + eps * self.omega * drift + vanishing

    def predictor(self, theta: float) -> Array:
        """Return the first lines of (2.2) and of Remark 2.11 as printed, and of the family between them."""
        h, eps, omega, omega_2 = self.h, self.eps, self.omega, self.omega_2
        free = self.x + np.sqrt(h) * SIGMA * self.xi + h * self.f
        if theta == 0.0:
            return free + 0.5 * omega**2 * self.quadratic + SIGMA**2 * eps / 8.0 * omega_2 * self.fixman
        if theta == 1.0:
            weight = SIGMA**2 / 4.0 * (np.sqrt(2.0 * eps * h * omega_2) - 0.5 * eps * omega_2)
            return free - 0.5 * omega**2 * self.quadratic + weight * self.fixman
        weight = (1.0 - 2.0 * theta) * 0.5 * eps * omega_2 + 2.0 * theta * np.sqrt(0.5 * eps * h * omega_2)
        return free + 0.5 * (1.0 - 2.0 * theta) * omega**2 * self.quadratic + SIGMA**2 / 4.0 * weight * self.fixman

    def solved(self, theta: float) -> Array:
        """Return x+ by a solver of all equations at once, from x+ = y and lambda = 0."""
        y, level = self.predictor(theta), self.level

        def defects(z: Array) -> Array:
            new, lam = z[:D], z[D:]
            normals = self.rough.gradient(self.x + theta * (new - self.x))
            return np.concatenate([new - y - normals @ lam, self.rough.zeta(new) - level])

        return root(defects, np.concatenate([y, 0.0 * level]), tol=1e-13).x[:D]


@pytest.mark.sweep
@pytest.mark.parametrize("eps", [1e-5, H, 3.0])
@pytest.mark.parametrize("theta", [0.0, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("q", [1, 2, 3])
def test_a_step_solves_the_printed_equations(q: int, theta: float, eps: float) -> None:
    """On and beside the manifold, in any codimension, for any direction."""
    x = points(q, 0.3 * min(1.0, np.sqrt(eps)))
    noise = increments(x)

    result = step(UniformlyAccurate(theta=theta), langevin(q, eps), x, noise)

    assert not result.failed.any()
    for p in range(x.shape[1]):
        printed = Printed(q, x[:, p], noise.dW[:, p] / np.sqrt(H), H, eps)
        # Powell's method stops where two iterates agree in 13 digits.
        assert np.abs(printed.solved(theta) - result.state[:, p]).max() < 1e-11


@pytest.mark.parametrize(("theta", "direction"), [(0.0, "old"), (1.0, "new")])
@pytest.mark.parametrize("q", [1, 3])
def test_the_limit_is_constrained_euler(q: int, theta: float, direction: str) -> None:
    """At eps = 0, on the manifold, a step is that of (1.6) or (2.7)."""
    x, problem = points(q, 0.0), langevin(q, 0.0)

    got = step(UniformlyAccurate(theta=theta), problem, x, increments(x))
    expected = step(ConstrainedEuler(direction=direction), problem, x, increments(x))

    assert not got.failed.any()
    assert np.abs(got.state - expected.state).max() < 64 * EPS


@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_frozen_gram_matrix_leads_to_the_same_step(q: int) -> None:
    """Both iterations end at the same root, the frozen one after more of them."""
    x = points(q, 0.05)
    newton, frozen = (
        step(UniformlyAccurate(solver=s), langevin(q, H), x, increments(x)) for s in ("newton", "frozen")
    )

    assert not (newton.failed | frozen.failed).any()
    assert np.abs(newton.state - frozen.state).max() < 64 * EPS
    assert frozen.costs["updates"].mean() > newton.costs["updates"].mean() + 1.0
    assert np.all(frozen.costs["newton_iterations"] == 1)


def test_the_law_follows_the_parameter() -> None:
    """Three-point variables are bounded; clipped ones by sqrt(2 p |ln h|)."""
    assert UniformlyAccurate(xi="three-point").law.bounded
    assert UniformlyAccurate(xi="clipped", p=2.0).law.bound(np.exp(-4.0)) == pytest.approx(4.0)
    assert UniformlyAccurate(xi="gaussian").law.bound(0.1) == np.inf
