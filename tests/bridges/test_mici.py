"""Integrators of mici as schemes; skipped where it is not installed."""

import numpy as np
import pytest

from facade import damped_pendulum, pendulum, pendulum_velocity_noise, sphere_langevin, violation
from sdaeverify import HolonomicSDAE, Increment
from sdaeverify.probing import OneStep
from sdaeverify_bridges.mici import Mici, friction

pytest.importorskip("mici", reason="needs the extra: pip install .[mici]")
H = 0.125


def line(gamma, mass):
    """Return a particle on the line r_2 = 0 with friction, a constant force and noise along it."""
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.5], [0.0]]) - gamma * mass * v,
        diffusion=lambda t, r, v: np.array([[[0.7]], [[0.3]]]),
        constraint=lambda r: r[1:],
        jacobian=lambda r: np.array([[[0.0], [1.0]]]) + 0.0 * r[:1],
        position=[0.3, 0.0],
        velocity=[1.0, 0.0],
        mass=mass * np.eye(2),
        noise_dim=1,
        horizon=1.0,
        source="a test",
    )


@pytest.mark.parametrize("inner", [1, 3])
def test_step_on_a_line_is_the_splitting(inner):
    """Half a leapfrog step, the Ornstein-Uhlenbeck step in law, half a leapfrog step; what points away is lost."""
    problem, gamma, mass = line(0.8, 2.0), 0.8, 2.0
    noise = Increment(np.array([[0.3, -0.2]]), None)
    v = 1.0 + 0.5 * H * 0.5 / mass
    middle = 0.3 + 0.5 * H * (1.0 + 0.25 * H * 0.5 / mass)
    s = np.sqrt((1.0 - np.exp(-2.0 * gamma * H)) / (2.0 * gamma * H))
    turned = np.exp(-gamma * H) * v + s * 0.7 / mass * noise.dW[0]
    scheme = Mici(inner)

    found = scheme.prepare(problem, H)(scheme.start(problem, 2, H), 0.0, noise)
    assert not found.failed.any()
    np.testing.assert_allclose(found.state.v, [turned + 0.5 * H * 0.5 / mass, [0.0, 0.0]], rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(found.state.r[0], middle + 0.5 * H * (turned + 0.25 * H * 0.5 / mass), rtol=1e-14)


@pytest.mark.parametrize("inner", [1, 3])
def test_free_motion_on_a_circle_is_by_chords(inner):
    """Without force and noise each move of length tau turns by arcsin(tau |v|), and the speed stays."""
    problem, scheme = pendulum(c_g=0.0, theta_0=0.5, omega_0=0.5), Mici(inner)
    nothing = Increment(np.zeros((problem.noise_dim, 1)), None)
    start = scheme.start(problem, 1, H)

    r, v, mu = scheme.prepare(problem, H)(start, 0.0, nothing).state
    turned = 2 * inner * np.arcsin(0.5 * H / inner * 0.5)
    cosine = float((r * start.r).sum())
    np.testing.assert_allclose(np.arccos(cosine), turned, rtol=1e-9)
    np.testing.assert_allclose((v * v).sum(axis=0), 0.25, rtol=1e-9)
    assert mu.shape == (0, 1)


def test_step_without_a_root_is_counted():
    """A path on which the solver finds no point of the manifold keeps its state."""
    problem, scheme = pendulum(c_g=0.0, omega_0=0.5), Mici()
    start = scheme.start(problem, 1, 8.0)

    end = scheme.prepare(problem, 8.0)(start, 0.0, Increment(np.zeros((problem.noise_dim, 1)), None))
    assert end.failed.all()
    np.testing.assert_array_equal(end.state.r, start.r)


def test_component_that_it_does_not_tell_is_no_fault():
    """Its step is exact on trivial equations in all but mu, and cannot be probed, since mu is compared there."""
    assert not violation(Mici(), damped_pendulum())
    assert OneStep(Mici(), damped_pendulum()).why_not_probed() == "the state of the scheme has no mu"


def test_friction_is_found():
    """It is the factor of -M v in the force; noise along v is refused."""
    assert friction(pendulum()) == 0.0
    np.testing.assert_allclose(
        [friction(damped_pendulum(gamma=0.7)), friction(sphere_langevin(gamma=0.3))], [0.7, 0.3]
    )
    assert friction(pendulum_velocity_noise()) is None
    assert Mici().refuses(pendulum_velocity_noise())
