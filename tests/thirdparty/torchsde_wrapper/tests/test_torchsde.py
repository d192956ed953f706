"""Steps of torchsde against their formulas, the conformance kit and the claims; skipped where torchsde is absent."""

from dataclasses import replace

import numpy as np
import pytest
from sdaeverify_torchsde.torchsde_method import TorchSDEMethod

from sdaeverify import SDE, Increment
from sdaeverify.testing import parametrize_with_checks, parametrize_with_claims

pytest.importorskip("torchsde", reason="torchsde is not installed; pip install 'sdaeverify-torchsde[torch]'")

METHODS = [TorchSDEMethod(), TorchSDEMethod("milstein"), TorchSDEMethod("euler")]
H, DW, X = 0.25, np.array([[0.3, -0.7, 0.0]]), np.array([[1.0, -2.0, 0.5]])


def multiplicative(t, x):
    """Return a diffusion that depends on time and state."""
    return (np.cos(x) + t)[:, None]


@pytest.fixture
def problem():
    """Return an equation with one Brownian motion."""
    return SDE(
        drift=lambda t, x: t - x**2,
        diffusion=multiplicative,
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="a test",
    )


def stepped(method, problem, t=0.5):
    """Make one step."""
    return TorchSDEMethod(method).step(problem, X, t, H, Increment(DW, 0.1 * DW)).state


def test_euler_is_the_formula(problem):
    """One step adds f h + B dW."""
    expected = X + H * (0.5 - X**2) + multiplicative(0.5, X)[:, 0] * DW

    np.testing.assert_allclose(stepped("euler", problem), expected, rtol=1e-14)


def test_milstein_uses_a_difference(problem):
    """One step adds (B(y) - B)(dW^2 - h)/(2 sqrt(h)) to Euler's, with y = x + f h + B sqrt(h)."""
    B = multiplicative(0.5, X)[:, 0]
    difference = multiplicative(0.5, X + H * (0.5 - X**2) + np.sqrt(H) * B)[:, 0] - B

    expected = X + H * (0.5 - X**2) + B * DW + difference * (DW**2 - H) / (2.0 * np.sqrt(H))
    np.testing.assert_allclose(stepped("milstein", problem), expected, rtol=1e-13)


def test_additive_noise_leaves_no_trace(problem):
    """A step is the same before and after one with additive noise, for which torchsde changes its options."""
    additive = replace(problem, diffusion=lambda t, x: 0.0 * x[:, None] + 1.0, traits=frozenset({"additive-noise"}))

    before = stepped("milstein", problem)
    stepped("milstein", additive)

    np.testing.assert_array_equal(stepped("milstein", problem), before)


def test_several_brownian_motions_that_are_not_diagonal_are_for_euler():
    """The other methods refuse noise that they are not made for."""
    problem = SDE(
        drift=lambda t, x: 0.0 * x,
        diffusion=lambda t, x: np.stack([x, x[::-1]]),
        start=[1.0, 2.0],
        noise_dim=2,
        horizon=1.0,
        source="a test",
    )

    assert [bool(scheme.refuses(problem)) for scheme in METHODS] == [True, True, False]


@parametrize_with_checks(METHODS, problems=["ou"])
def test_contract(subject, check):
    """Each method passes the conformance kit."""
    check(subject)


@parametrize_with_claims(METHODS, problems=["ou"])
def test_claim(subject, check):
    """No claim of a method is refuted."""
    check(subject)
