"""The inherent SDE (2.9) against hand-written derivatives and the identities that characterise it."""

import numpy as np
import pytest

from sdaeverify import SDE, HolonomicSDAE

EPS = np.finfo(float).eps
PATHS = 6

# ---------------------------------------------------------------- pendulum: everything in closed form


def pendulum(c_g):
    """Return the pendulum, its derivatives left to the complex step."""
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-c_g]]),
        diffusion=lambda t, r, v: np.eye(2)[..., None],
        constraint=lambda r: (0.5 - 0.5 * (r[0] ** 2 + r[1] ** 2))[None],
        position=[0.6, -0.8],
        velocity=[0.8, 0.6],
        horizon=1.0,
        noise_dim=2,
        source="Lindner & Stroot 2017, section 5.1",
    )


def plane_points():
    """Return positions around the circle, not on it, and velocities in all directions."""
    angle = np.arange(PATHS)
    r = (0.8 + 0.1 * angle) * np.array([np.sin(angle), -np.cos(angle)])
    return r, np.array([np.cos(3.0 * angle), 2.0 * np.sin(angle + 1.0)])


@pytest.mark.parametrize("c_g", [0.0, 1.0, 9.81])
def test_pendulum_has_its_closed_form(c_g):
    """The velocity has dv = (P a - |v|^2/|r|^2 r) dt + P dw, P = Id - r r^T/|r|^2, on the circle and off it."""
    r, v = plane_points()
    sde = pendulum(c_g).view(SDE)
    P = np.eye(2)[..., None] - np.einsum("ip,jp->ijp", r, r) / (r**2).sum(axis=0)
    acceleration = -c_g * P[:, 1] - (v**2).sum(axis=0) / (r**2).sum(axis=0) * r
    x = np.concatenate([r, v])
    # D^2 g comes from g by `second_directional`; g is quadratic, so that only eps/s = 2e-13 of it is left.
    bound = 1e-11 * (1.0 + (v**2).sum(axis=0)) + 64 * EPS * c_g
    assert np.array_equal(sde.drift(0.0, x)[:2], v)
    assert (np.abs(sde.drift(0.0, x)[2:] - acceleration) <= bound).all()
    assert np.array_equal(sde.diffusion(0.0, x)[:2], np.zeros((2, 2, PATHS)))
    assert np.abs(sde.diffusion(0.0, x)[2:] - P).max() <= 32 * EPS


def test_multiplier_is_the_tension_of_the_pendulum():
    """With r = (sin theta, -cos theta) and v = omega t, dmu = (c_g cos(theta) + omega^2) dt."""
    theta, omega = np.linspace(-3.0, 3.0, PATHS), np.linspace(-2.0, 2.0, PATHS)
    r, t = np.array([np.sin(theta), -np.cos(theta)]), np.array([np.cos(theta), np.sin(theta)])
    a = np.broadcast_to(np.array([[0.0], [-9.81]]), r.shape)
    problem = pendulum(9.81)
    tension = problem.inherent_multiplier(problem.linearised(r), r, omega * t, a)
    assert (np.abs(tension - (9.81 * np.cos(theta) + omega**2)) <= 1e-11 * (1.0 + omega**2) + 64 * EPS * 9.81).all()


# ---------------------------------------------------------------- general mass and constraints in R^3

MASS = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 3.0]])
SIGMA = 0.7
START = np.array([0.5, -0.4, 0.3])


def all_constraints(x):
    """Return x_0^2 + x_1^2 x_2/2 + sin x_2 and x_0 x_1 + exp x_2."""
    return np.stack([x[0] ** 2 + 0.5 * x[1] ** 2 * x[2] + np.sin(x[2]), x[0] * x[1] + np.exp(x[2])])


def gradients(x):
    """Return their first derivatives, shape (2, 3, P)."""
    first = [2.0 * x[0], x[1] * x[2], 0.5 * x[1] ** 2 + np.cos(x[2])]
    return np.stack([np.stack(first), np.stack([x[1], x[0], np.exp(x[2])])])


def force(t, r, v):
    """Return a force that depends on everything."""
    return np.stack([np.sin(r[1]) - v[0], r[0] * v[2], -1.0 + v[1] ** 2 + t])


def tangent(m, r, y):
    """Return the part of y that the first m constraints allow at r, by least squares on every path."""
    return np.stack([b - np.linalg.pinv(A) @ (A @ b) for A, b in paths(gradients(r)[:m], y)], axis=-1)


def paths(A, y):
    """Return the pairs of matrix and vector of every path."""
    return [(A[..., p], y[..., p]) for p in range(y.shape[-1])]


def general(m):
    """Return a problem in R^3 with a full mass matrix and m constraints; noise with B B^T = sigma^2 M."""
    offset = all_constraints(START[:, None])[:m]
    B = SIGMA * np.linalg.cholesky(MASS)
    return HolonomicSDAE(
        force=force,
        diffusion=lambda t, r, v: B[..., None],
        constraint=lambda r: all_constraints(r)[:m] - offset,
        jacobian=lambda r: gradients(r)[:m],
        position=START,
        velocity=tangent(m, START[:, None], np.array([[1.0], [-1.0], [0.5]]))[:, 0],
        mass=MASS,
        horizon=1.0,
        noise_dim=3,
        source="made up",
    )


def points():
    """Return positions around the manifold and arbitrary velocities: the identities hold for all of them."""
    wave = np.sin(np.arange(6 * PATHS).reshape(6, PATHS) ** 2.0)
    return START[:, None] + 0.2 * wave[:3], wave[3:]


def rounding(m, r):
    """Return 64 eps times the condition numbers of mass and Gram matrix, the size of all errors below."""
    Dg = gradients(r)[:m]
    grams = [Dg[..., p] @ np.linalg.solve(MASS, Dg[..., p].T) for p in range(r.shape[-1])]
    return 64 * EPS * np.linalg.cond(MASS) * max(np.linalg.cond(G) for G in grams)


# ---------------------------------------------------------------- what the view takes over


def test_the_view_keeps_what_is_known_of_the_problem():
    """Start, names, horizon, noise and units are those of the constrained problem; its source says so."""
    problem = general(2)
    sde = problem.view(SDE)
    assert np.array_equal(sde.start, np.concatenate([problem.position, problem.velocity]))
    assert (sde.horizon, sde.noise_dim, sde.units) == (problem.horizon, problem.noise_dim, problem.units)
    assert (sde.observables, sde.truths) == (problem.observables, problem.truths)
    assert "(2.9)" in sde.source
    parts = sde.parts(np.arange(12.0).reshape(6, 2))
    assert {name: rows.tolist() for name, rows in parts.items()} == {
        "r": [[0, 1], [2, 3], [4, 5]],
        "v": [[6, 7], [8, 9], [10, 11]],
    }


def test_additive_noise_is_not_additive_in_the_view():
    """The projector depends on r; but as only v is driven, the Milstein term vanishes."""
    problem = HolonomicSDAE(**{**fields_of(pendulum(1.0)), "traits": frozenset({"additive-noise"})})
    sde = problem.view(SDE)
    assert sde.traits == {"vanishing-milstein-term", "constrained", "no-delay"}
    r, v = plane_points()
    x = np.concatenate([r, v])
    B = sde.diffusion(0.0, x)
    corrections = [sde.derivative_of_diffusion(0.0, x, B[:, j]) for j in range(2)]
    assert np.array_equal(corrections, np.zeros((2, 4, 2, PATHS)))


def test_the_diffusion_can_be_differentiated_without_a_given_jacobian():
    """DB of the view is the same whether Dg was given or taken by complex step."""
    given = general(2)
    taken = HolonomicSDAE(**{**fields_of(given), "jacobian": None}).view(SDE)
    r, v = points()
    x, y = np.concatenate([r, v]), np.concatenate([v, r])
    assert taken.why_not_derivative_of_diffusion() == ""
    expected = given.view(SDE).derivative_of_diffusion(0.0, x, y)
    difference = np.abs(taken.derivative_of_diffusion(0.0, x, y) - expected)
    # Second derivatives without Dg are good to 5e-11, which the condition of the projector enlarges.
    assert np.abs(expected).max() > 0.1
    assert difference.max() <= 5e-11 * rounding(2, r) / EPS


def fields_of(problem):
    """Return the arguments a problem was made of."""
    return {name: getattr(problem, name) for name in problem.__dataclass_fields__}


def test_the_problem_itself_is_its_view_as_constrained_mechanics():
    """Asked for its own form it returns itself."""
    problem = pendulum(1.0)
    assert problem.view(HolonomicSDAE) is problem
