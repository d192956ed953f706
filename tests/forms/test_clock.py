"""Constraints that move: a further position of infinite mass is the time."""

import numpy as np
import pytest

from facade import HalfExplicitEuler
from forms.refusing import refusal
from sdaeverify import HolonomicSDAE, Increment

WEIGHT, SPRING, H = -3.0, 2.0, 1.0 / 64.0


def lift(**changed):
    """Return a body (x, y) on a floor that goes up and down, y = sin(s) at the time s, with a spring and noise."""
    given = {
        "force": lambda t, r, v: np.stack([-SPRING * r[0], WEIGHT + 0.0 * r[1], 7.0 + 0.0 * r[2]]),
        "diffusion": lambda t, r, v: np.array([[0.5, 0.0], [0.0, 0.8], [0.3, 0.3]])[..., None] + 0.0 * r[:1, None],
        "constraint": lambda r: r[1:2] - np.sin(r[2:]),
        "constraint_bound": 2.0,
        "position": [1.0, 0.0, 0.0],
        "velocity": [0.0, 1.0, 1.0],
        "mass": np.diag([2.0, 2.0, np.inf]),
        "noise_dim": 2,
        "horizon": 1.0,
        "source": "a test",
    }
    return HolonomicSDAE(**{**given, **changed})


def test_inherent_equation_follows_the_floor():
    """The body rises with y'' = -sin(s), the floor bears it, and neither force nor noise moves the clock."""
    problem, s = lift(), np.array([0.0, 0.7, 2.0])
    r, v = np.stack([1.0 + 0.0 * s, np.sin(s), s]), np.stack([0.3 + 0.0 * s, np.cos(s), 1.0 + 0.0 * s])
    x = np.concatenate([r, v, 0.0 * r[:1]])

    drift, B = problem.ito().drift(0.0, x), problem.ito().diffusion(0.0, x)

    np.testing.assert_allclose(drift[3], -SPRING / 2.0, rtol=1e-14)
    np.testing.assert_allclose(drift[4], -np.sin(s), atol=1e-14)
    np.testing.assert_allclose(drift[6], -2.0 * np.sin(s) - WEIGHT, rtol=1e-13)
    assert not drift[5].any()
    assert not B[4:6].any() or np.abs(B[4:6]).max() < 1e-15
    np.testing.assert_allclose(B[6, 1], -0.8, rtol=1e-14)


def test_scheme_keeps_a_constraint_that_moves():
    """The half-explicit Euler scheme keeps y = sin(t) to rounding, with noise, and its clock shows the time."""
    problem, scheme, paths = lift(), HalfExplicitEuler(truncation="none"), 5
    rng, state = np.random.default_rng(3), scheme.start(problem, paths, H)
    step = scheme.prepare(problem, H)

    for n in range(64):
        made = step(state, n * H, Increment(np.sqrt(H) * rng.standard_normal((2, paths)), None))
        state = made.state
        assert made.failed is None or not made.failed.any()

    np.testing.assert_allclose(state.r[2], 1.0, rtol=1e-14)
    np.testing.assert_allclose(state.r[1], np.sin(1.0), atol=1e-12)
    assert np.ptp(state.r[0]) > 0.1


def test_energy_norm_leaves_the_clock_out():
    """A position of infinite mass has no kinetic energy to count."""
    problem, one = lift(), np.ones((3, 1))

    assert problem.squared_norm({"r": 0.0 * one, "v": one}) == pytest.approx([4.0])


@pytest.mark.parametrize(
    ("mass", "text"),
    [
        ([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, np.inf]], "mass must be a finite matrix"),
        (np.diag([np.inf, np.inf, np.inf]), "finite in at least one direction"),
        (np.diag([1.0, -np.inf, 1.0]), "mass must be a finite matrix"),
    ],
)
def test_clocks_stand_alone(mass, text):
    """What couples a clock with others, or leaves nothing to be moved, is refused."""
    assert text in refusal(lift, mass=mass)
