"""Geodesic BAOAB: closed forms on the circle, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ive
from sdaeverify_geodesic.ellipse_langevin import coordinates, ellipse_langevin, embedded, invariant_means
from sdaeverify_geodesic.geodesic_baoab import GeodesicBAOAB

from sdaeverify import HolonomicSDAE, HolonomicState, Increment, ParameterError

H = 0.125
OMEGA = np.array([-1.5, 0.3, 2.0])


def on_sphere(n=2, force=lambda t, r, v: 0.0 * v, noise=0.0, mass=None, start=None):
    """Return motion on the unit sphere of R^n."""
    B = np.diag(np.broadcast_to(np.asarray(noise, dtype=float), n))
    return HolonomicSDAE(
        force=force,
        diffusion=lambda t, r, v: B[..., None],
        constraint=lambda r: 0.5 * (r * r).sum(axis=0, keepdims=True) - 0.5,
        jacobian=lambda r: r[None],
        curvature=lambda r, y, z: (y * z).sum(axis=0, keepdims=True),
        position=np.eye(n)[0],
        velocity=np.eye(n)[1],
        mass=mass,
        horizon=1.0,
        noise_dim=n,
        source="a test",
    )


def rotating(omega):
    """Return states on the circle at the angle 0 with given angular velocities."""
    zero = np.zeros((1, len(omega)))
    return HolonomicState(np.concatenate([zero + 1.0, zero]), np.concatenate([zero, omega[None]]), zero)


def stepped(problem, state, h=H, dW=0.0, scheme=None):
    """Make one step."""
    noise = Increment(np.full((problem.noise_dim, state.r.shape[1]), dW), None)
    return (scheme or GeodesicBAOAB()).prepare(problem, h)(state, 0.0, noise)


@pytest.mark.parametrize("moves", [1, 3])
def test_free_rotation_follows_the_circle(moves):
    """Each of the moves turns by arcsin(tau omega), tau = h/(2 moves), and keeps the speed; mu takes omega^2 h."""
    state, steps = rotating(OMEGA), 2 * moves

    r, v, mu = stepped(on_sphere(), state, scheme=GeodesicBAOAB(moves)).state

    tau = H / steps
    np.testing.assert_allclose(np.arctan2(r[1], r[0]), steps * np.arcsin(tau * OMEGA), rtol=1e-13)
    np.testing.assert_allclose(np.hypot(*v), np.abs(OMEGA), rtol=1e-13)
    # Each of the two impulses of a move is tan(phi/2) omega, with sin(phi) = tau omega.
    half = np.tan(0.5 * np.arcsin(tau * OMEGA)) * OMEGA
    np.testing.assert_allclose(-mu[0], 2 * steps * half, rtol=1e-12)


def test_friction_is_exact():
    """Without force and noise the speed falls by e^{-gamma h}, whatever h."""
    problem = on_sphere(force=lambda t, r, v: -2.0 * v)

    v = stepped(problem, rotating(OMEGA)).state.v

    np.testing.assert_allclose(np.hypot(*v), np.exp(-2.0 * H) * np.abs(OMEGA), rtol=1e-13)


def test_noise_has_the_variance_of_the_exact_step():
    """From rest, one step gives the speed sqrt((1 - c^2)/(2 gamma h)) |B dW| along the circle."""
    problem = on_sphere(force=lambda t, r, v: -2.0 * v, noise=0.7)

    v = stepped(problem, rotating(np.zeros(1)), dW=0.1).state.v

    expected = 0.7 * 0.1 * np.sqrt((1.0 - np.exp(-4.0 * H)) / (4.0 * H))
    np.testing.assert_allclose(np.hypot(*v), expected, rtol=1e-13)


def test_step_without_friction_and_noise_is_reversible():
    """With the velocity turned round, a second step leads back to the start."""
    weight = np.array([[0.0], [-1.0]])
    problem = on_sphere(force=lambda t, r, v: weight + 0.0 * v)
    start = rotating(OMEGA)

    there = stepped(problem, start).state
    back = stepped(problem, there._replace(v=-there.v)).state

    np.testing.assert_allclose(back.r, start.r, atol=1e-14)
    np.testing.assert_allclose(-back.v, start.v, atol=1e-14)


def test_path_without_root_keeps_its_state():
    """A move further than the circle is wide finds no root: the path is counted as failed and stays where it is."""
    state = rotating(np.array([1.0, 100.0]))

    step = stepped(on_sphere(), state)

    assert step.failed.tolist() == [False, True]
    np.testing.assert_array_equal(step.state.v[:, 1], state.v[:, 1])


@pytest.mark.parametrize(
    ("problem", "reason"),
    [
        (on_sphere(force=lambda t, r, v: -v * np.sqrt((v * v).sum(axis=0))), "force"),
        (on_sphere(force=lambda t, r, v: -v * r[:1]), "force"),
        (on_sphere(force=lambda t, r, v: np.sin(t) * np.ones_like(v)), "force"),
        (on_sphere(3, force=lambda t, r, v: -np.array([[1.0], [2.0], [1.0]]) * v), "force"),
        (on_sphere(3, force=lambda t, r, v: -v, mass=np.diag([1.0, 2.0, 1.0])), "force"),
        (on_sphere(3, noise=[1.0, 2.0, 1.0]), "isotropic"),
        (replace(on_sphere(), diffusion=lambda t, r, v: v[:1] * np.eye(2)[..., None]), "velocity"),
        (replace(on_sphere(), diffusion=lambda t, r, v: (1.0 + t) * np.eye(2)[..., None]), "time"),
    ],
)
def test_other_dynamics_are_refused(problem, reason):
    """Friction that is not one number, noise that is not isotropic or not constant: refused with the reason."""
    assert reason in GeodesicBAOAB().refuses(problem)


@pytest.mark.parametrize(
    "problem",
    [
        on_sphere(3, noise=0.5, mass=2.0 * np.eye(3), force=lambda t, r, v: -v),
        on_sphere(3, force=lambda t, r, v: r * r - 0.3 * v),
        ellipse_langevin(),
    ],
)
def test_canonical_dynamics_are_accepted(problem):
    """A force of the position, one friction and isotropic noise are what the scheme is for."""
    assert GeodesicBAOAB().refuses(problem) == ""


def test_moves_are_counted():
    """There is at least one move."""
    with pytest.raises(ParameterError, match="moves must be at least 1"):
        GeodesicBAOAB(0)


def test_coordinates_are_read_from_what_is_embedded():
    """Angle and speed determine the state on the ellipse, and the other way round."""
    axes = np.array([[1.3], [1.0]])
    z = np.array([[0.3, -2.0, 3.0], [0.5, -1.0, 2.0]])

    np.testing.assert_allclose(coordinates(axes, embedded(axes, z)), z, rtol=1e-14)


def test_means_on_the_circle_are_those_of_von_mises():
    """Where both half axes are 1, the mean of r_1 is I_1/I_0 (force/kT)."""
    means = invariant_means(1.0, 0.4, 0.5)

    assert means["r_1"] == pytest.approx(ive(1, 0.8) / ive(0, 0.8), rel=1e-13)
    assert means["r_1^2"] + means["r_2^2"] == pytest.approx(1.0, rel=1e-13)
