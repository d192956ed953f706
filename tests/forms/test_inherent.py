"""The inherent SDE (2.9) against hand-written derivatives and the identities that characterise it."""

import numpy as np
import pytest

from sdaeverify import SDE, HolonomicSDAE

EPS = np.finfo(float).eps
PATHS = 6


def pendulum(c_g, traits=frozenset()):
    """Return the pendulum, its derivatives left to the complex step."""
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-c_g]]),
        diffusion=lambda t, r, v: np.eye(2)[..., None],
        constraint=lambda r: (0.5 - 0.5 * (r[0] ** 2 + r[1] ** 2))[None],
        position=[0.6, -0.8],
        velocity=[0.8, 0.6],
        horizon=1.0,
        noise_dim=2,
        traits=traits,
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


def test_additive_noise_is_not_additive_in_the_view():
    """The projector depends on r; but as only v is driven, the Milstein term vanishes."""
    sde = pendulum(1.0, frozenset({"additive-noise"})).view(SDE)
    assert sde.traits == {"vanishing-milstein-term", "commutative-noise", "constrained", "no-delay"}
    r, v = plane_points()
    x = np.concatenate([r, v])
    B = sde.diffusion(0.0, x)
    corrections = [sde.derivative_of_diffusion(0.0, x, B[:, j]) for j in range(2)]
    assert np.array_equal(corrections, np.zeros((2, 4, 2, PATHS)))


def test_the_view_keeps_what_is_known_of_the_problem():
    """Start, names, horizon, noise and units are those of the constrained problem, which is its own view as such."""
    problem = pendulum(1.0)
    sde = problem.view(SDE)
    assert problem.view(HolonomicSDAE) is problem
    assert np.array_equal(sde.start, np.concatenate([problem.position, problem.velocity]))
    for name in ("horizon", "noise_dim", "units", "observables", "truths"):
        assert getattr(sde, name) == getattr(problem, name)
    assert "(2.9)" in sde.source
    parts = sde.parts(np.arange(8.0).reshape(4, 2))
    assert {name: rows.tolist() for name, rows in parts.items()} == {"r": [[0, 1], [2, 3]], "v": [[4, 5], [6, 7]]}
