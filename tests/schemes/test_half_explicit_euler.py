"""The half-explicit scheme against closed forms, an independent solver, and the estimates of the theory."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from facade import HalfExplicitEuler, pendulum
from facade import _circle as circle
from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, Step

EPS = np.finfo(float).eps
NONE = HalfExplicitEuler(truncation="none")
C_G = circle.CONSTRAINT_BOUND


def move(scheme: HalfExplicitEuler, problem: HolonomicSDAE, state: HolonomicState, h: float, dW: Array) -> Step:
    """Make one step; on paths without root Newton's method may divide by zero, as it may in a run."""
    with np.errstate(all="ignore"):
        return scheme.prepare(problem, h)(state, 0.3, Increment(dW, np.full_like(dW, np.nan)))


class Angles(NamedTuple):
    """Paths of the pendulum in angle form."""

    theta: Array
    omega: Array
    mu: Array
    dW: Array

    @property
    def state(self) -> HolonomicState:
        return HolonomicState(circle.normal(self.theta), self.omega * circle.tangent(self.theta), self.mu[None])


def angles(omega: Array, h: float) -> Angles:
    rng = np.random.default_rng(12)
    n = omega.size
    return Angles(rng.uniform(-3, 3, n), omega, rng.standard_normal(n), np.sqrt(h) * rng.standard_normal((2, n)))


class ClosedForm(NamedTuple):
    """One step on the circle: sheet of formulas, section 3.1."""

    eta: Array
    kappa: Array
    theta: Array
    omega: Array
    lam: Array


def closed_form(x: Angles, c_g: float, h: float, C_eta: float) -> ClosedForm:
    """Return the step in angle form.

    With sin(phi) = eta omega h: kappa = 1 - cos(phi), theta+ = theta + phi,
    omega+ = (omega + eta a_t h + <t, dW>) / cos(phi), lambda = <y, r> + <y, t> tan(phi), y = v + eta h a + dW.
    """
    r, t = circle.normal(x.theta), circle.tangent(x.theta)
    size = h * np.maximum(np.maximum(np.abs(x.omega), x.omega**2), c_g)
    eta = np.minimum(1.0, C_eta / size)
    phi = np.arcsin(eta * x.omega * h)
    y = x.omega * t + eta * h * np.array([[0.0], [-c_g]]) + x.dW
    y_r, y_t = (y * r).sum(axis=0), (y * t).sum(axis=0)
    return ClosedForm(eta, 2 * np.sin(phi / 2) ** 2, x.theta + phi, y_t / np.cos(phi), y_r + y_t * np.tan(phi))


OPTIONS = [("none", np.inf), ("theory", 1 / (4 * C_G**3)), (0.05, 0.05), (0.9, 0.9)]


@pytest.mark.parametrize(("truncation", "C_eta"), OPTIONS)
@pytest.mark.parametrize("c_g", [0.0, 1.0, 2.5])
def test_a_step_on_the_circle_is_the_closed_form(truncation: str | float, C_eta: float, c_g: float) -> None:
    """Position, velocity, multipliers and marks agree with formulas in the angle, up to 60 degrees in one step."""
    h = 0.5
    x = angles(np.linspace(-1.7, 1.7, 41), h)

    step = move(HalfExplicitEuler(truncation=truncation), pendulum(c_g=c_g), x.state, h, x.dW)

    expected = closed_form(x, c_g, h, C_eta)
    turned = expected.omega * circle.tangent(expected.theta)
    # The largest turn has cos(phi) > 1/2; conditions of the root and of the projection are its inverse.
    error = 64 * EPS * (1.0 + np.abs(expected.omega) + np.abs(expected.lam))
    assert not step.failed.any()
    assert np.all(np.abs(step.outputs["kappa"][0] - expected.kappa) <= error)
    assert np.all(np.abs(step.state.r - circle.normal(expected.theta)) <= error)
    assert np.all(np.abs(step.state.v - turned) <= error)
    assert np.all(np.abs(step.outputs["lambda"][0] - expected.lam) <= error)
    assert np.all(np.abs(step.state.mu[0] - x.mu - expected.lam) <= error)
    if truncation == "none":
        assert step.truncated is None
    else:
        assert np.array_equal(step.truncated, expected.eta < 1.0)


@pytest.mark.parametrize("no_root", ["hold", "fail"])
def test_paths_without_root_are_reported(no_root: str) -> None:
    """Where |omega| h > 1 there is no root: the path is reported, and held or lost as the parameter says."""
    x, h = angles(np.array([0.5, 2.001, -1.0, 5.0, -300.0, 1.99, 1e6]), 0.5), 0.5
    rootless = np.abs(x.omega) * h > 1.0

    step = move(HalfExplicitEuler(truncation="none", no_root=no_root), pendulum(), x.state, h, x.dW)

    assert np.array_equal(step.failed, rootless)
    for new, old in zip(step.state, x.state, strict=True):
        kept = old if no_root == "hold" else np.full_like(old, np.nan)
        assert np.array_equal(new[:, rootless], kept[:, rootless], equal_nan=True)


def test_the_root_keeps_the_bounds_of_the_theory() -> None:
    """|kappa| < C_g^2 (eta min(C_eta, h)^2 + eta^2 |v|^2 h^2) <= C_kappa, (3.21), at any speed and any step."""
    C_eta, C_kappa = 1 / (4 * C_G**3), 1 / (8 * C_G**4)
    for h in (1e-3, 0.1, 1.0, 50.0):
        x = angles(np.geomspace(1e-2, 1e6, 60), h)
        eta = closed_form(x, 1.0, h, C_eta).eta

        kappa = np.abs(move(HalfExplicitEuler(), pendulum(), x.state, h, x.dW).outputs["kappa"][0])

        bound = C_G**2 * (eta * min(C_eta, h) ** 2 + (eta * x.omega * h) ** 2)
        assert np.all(kappa < bound)
        assert np.all(bound <= C_kappa * (1 + 8 * EPS))


def scaled(s: float, **more: Any) -> HolonomicSDAE:
    """Return the pendulum with the constraint s g."""
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-1.0]]),
        diffusion=lambda t, r, v: np.eye(2)[..., None],
        constraint=lambda r: s * circle.constraint(r),
        position=[0.0, -1.0],
        velocity=[0.0, 0.0],
        horizon=1.0,
        noise_dim=2,
        source="made up",
        **more,
    )


@pytest.mark.parametrize(("C_g", "s"), [(1.0, 0.1), (1.5, 0.05)])
def test_roots_beyond_the_bound_of_the_theory_are_not_accepted(C_g: float, s: float) -> None:
    """A problem that understates C_g loses its paths with |kappa| >= C_kappa; a number in its place does not check.

    With the constraint s g, kappa = (1 - cos(phi)) / s.
    """
    problem, C_eta, C_kappa = scaled(s, constraint_bound=C_g), 1 / (4 * C_g**3), 1 / (8 * C_g**4)
    x = angles(np.linspace(0.05, 1.0, 39), 0.25)
    kappa = closed_form(x, 1.0, 0.25, C_eta).kappa / s

    checked, unchecked = (
        move(HalfExplicitEuler(truncation=truncation), problem, x.state, 0.25, x.dW).failed
        for truncation in ("theory", C_eta)
    )

    assert kappa.max() > C_kappa > kappa.min()
    assert np.array_equal(checked, kappa >= C_kappa)
    assert not unchecked.any()


def test_the_near_root_is_taken_on_the_sphere(sphere: Any) -> None:
    """With a mass matrix kappa is the root c / (b + sqrt(b^2 - A c)) of smaller modulus, as long as there is one.

    kappa solves A kappa^2 - 2 b kappa + c = 0, A = |M^{-1} r|^2, b = <M^{-1} r, r + h v>, c = |r + h v|^2 - 1.
    """
    r, v, _ = sphere.state
    n = np.linalg.solve(sphere.mass, r)
    dW = np.zeros((2, r.shape[1]))
    outcomes = []
    for h in np.geomspace(0.01, 3.0, 60):
        y = r + h * v
        A, b, c = (n * n).sum(axis=0), (n * y).sum(axis=0), (y * y).sum(axis=0) - 1.0
        discriminant = b * b - A * c
        solvable = (discriminant > 0.0) & (b > 0.0)
        apart = np.abs(discriminant) > 1e-3 * b * b

        step = move(NONE, sphere.problem, sphere.state, h, dW)

        near = c[solvable] / (b + np.sqrt(np.where(solvable, discriminant, 0.0)))[solvable]
        assert np.array_equal(step.failed[apart], ~solvable[apart])
        # The root is badly conditioned where the two meet: rounding of c over sqrt(b^2 - A c).
        error = (64 * EPS * (1.0 + c) / np.sqrt(np.abs(discriminant)))[solvable]
        known = apart[solvable]
        assert np.all(np.abs(step.outputs["kappa"][0, solvable] - near)[known] <= error[known])
        outcomes += list(solvable)

    assert any(outcomes)
    assert not all(outcomes)


def test_the_theory_needs_its_constant() -> None:
    """Without C_g the theoretical truncation is refused with a way out, the others are not."""
    reason = HalfExplicitEuler().refuses(scaled(1.0))

    assert "constraint_bound" in reason
    assert "truncation=none" in reason
    assert not NONE.refuses(scaled(1.0))
    assert not HalfExplicitEuler(truncation=0.1).refuses(scaled(1.0))
    assert not HalfExplicitEuler().refuses(pendulum())
