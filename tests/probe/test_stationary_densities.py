"""Stationary densities on a chart: those of laws that are known, and what tells that one is not resolved."""

import numpy as np
import pytest

from facade import Densities, EulerMaruyama, angle_pendulum, ou, stationary_densities


def normal(x, deviation):
    """Return the density of a centred normal law."""
    return np.exp(-0.5 * (x / deviation) ** 2) / (np.sqrt(2.0 * np.pi) * deviation)


def test_the_density_of_a_linear_equation_and_of_euler():
    """Where dx = -k x dt + s dW, variances are s^2/(2 k), and s^2/(2 k - k^2 h) for Euler: both laws are normal."""
    problem, h = ou(), 0.0625
    k, s = 1.0 / problem.relaxation_time, float(problem.diffusion(0.0, np.zeros((1, 1)))[0, 0, 0])

    found = stationary_densities(EulerMaruyama(), problem, h)

    assert found.resolved
    assert found.exact[0] == pytest.approx(normal(found.at[0], s / np.sqrt(2.0 * k)), rel=1e-9)
    assert found.scheme[0] == pytest.approx(normal(found.at[0], s / np.sqrt(2.0 * k - k**2 * h)), abs=1e-6)


def test_marginal_densities_of_two_coordinates():
    """Of a pendulum the angle has the density exp(-V/kT), its velocity a normal one; each has the integral 1."""
    problem = angle_pendulum()

    found = stationary_densities(EulerMaruyama(), EulerMaruyama().view_of(problem), 0.01)

    angle, velocity = found.at
    assert np.trapezoid(found.exact[0], angle) == pytest.approx(1.0, abs=1e-9)
    scale = problem.chart.axes[1].scale
    assert found.exact[1] == pytest.approx(normal(velocity, scale), abs=1e-9)
    assert np.abs(found.scheme - found.exact).max() < 0.05


def test_an_expansion_that_is_negative_is_not_resolved():
    """A law that the functions of the basis do not represent is not taken for one."""
    at = np.linspace(-1.0, 1.0, 3)[None]
    right = np.array([[0.2, 0.6, 0.2]])

    assert Densities(np.array(0.1), at, right, right).resolved
    assert not Densities(np.array(0.1), at, np.array([[-0.1, 1.2, -0.1]]), right).resolved
    assert not Densities(np.array(0.1), at, right * np.nan, right).resolved
