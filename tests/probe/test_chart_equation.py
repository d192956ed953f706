"""The Ito equation of a chart's coordinates against closed forms, and charts that are none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from facade import chart_basis
from probe.chart_cells import ANGLE, OU, embed, free_moments, plane_pendulum, read
from sdaeverify import Angle, Chart, Line, ProblemError
from sdaeverify.probe.operator.chart_equation import coefficients, generator, output_rows, require_chart

POINTS = np.array([[0.1, 1.0, -2.0, 3.0], [0.3, -1.0, 2.0, 0.0]])


def test_coordinates_that_are_components_keep_the_equation():
    """An identity chart has the drift and the diffusion of the problem."""
    b, s = coefficients(*require_chart(ANGLE), POINTS)
    assert np.allclose(b, ANGLE.drift(0.0, POINTS), rtol=0.0, atol=1e-15)
    assert np.allclose(s, ANGLE.diffusion(0.0, POINTS), rtol=0.0, atol=1e-15)


def test_the_pendulum_in_the_plane_has_its_angle_form():
    """Its angle has the drift (omega, -c sin theta - gamma omega) and the noise sigma <t, dw>, no Ito correction."""
    theta, omega = POINTS
    b, s = coefficients(*require_chart(plane_pendulum(c_g=2.0, gamma=0.3, sigma=0.7, noises=2)), POINTS)
    # D^2 g and D^2 embed come from second differences of size 1e-3: 1e-12 of |v|^2 is left.
    assert np.allclose(b, [omega, -2.0 * np.sin(theta) - 0.3 * omega], rtol=0.0, atol=1e-11)
    assert np.allclose(s, 0.7 * np.stack([[0.0 * theta, 0.0 * theta], [np.cos(theta), np.sin(theta)]]), atol=1e-14)


def test_ito_correction_of_a_curved_chart_is_found():
    """Of dx = -x dt + sigma dW in z = arsinh x, dz = (-tanh z - (sigma^2/2) sinh z/cosh^3 z) dt + sigma/cosh z dW."""
    curved = replace(OU, chart=Chart((Line(0.0, 1.0),), np.sinh, np.arcsinh))
    z = POINTS[:1]
    b, s = coefficients(*require_chart(curved), z)
    assert np.allclose(b, -np.tanh(z) - 0.5 * 0.49 * np.sinh(z) / np.cosh(z) ** 3, rtol=0.0, atol=1e-11)
    assert np.allclose(s[0], 0.7 / np.cosh(z), rtol=0.0, atol=1e-14)


def test_a_solution_that_leaves_the_image_is_refused():
    """A chart that fixes the angular velocity of a pendulum with noise is none."""
    frozen = Chart((Angle(),), lambda z: embed(np.stack([z[0], 0.5 + 0.0 * z[0]])), lambda x: read(x)[:1])
    with pytest.raises(ProblemError, match="leaves the image"):
        coefficients(*require_chart(replace(plane_pendulum(), chart=frozen)), POINTS[:1])


def test_an_embedding_without_complex_steps_is_refused():
    """The function abs is not analytic."""
    kinked = replace(OU, chart=Chart((Line(0.0, 1.0),), np.abs, lambda x: x))
    with pytest.raises(ProblemError, match="not analytic"):
        coefficients(*require_chart(kinked), POINTS[1:])


def test_multipliers_are_pure_outputs_and_positions_are_not():
    """Only rows that stay at zero and that no coefficient depends on are outputs."""
    assert output_rows(*require_chart(plane_pendulum()), POINTS).tolist() == [False] * 4 + [True]
    assert not output_rows(*require_chart(ANGLE), POINTS).any()


def test_a_component_held_at_zero_is_no_output_if_the_equation_needs_it():
    """A chart that puts the velocity to zero does not make it an output."""
    ito, _ = require_chart(ANGLE)
    flat = Chart((Angle(),), lambda z: np.stack([z[0], 0.0 * z[0]]), lambda x: x[:1])
    assert not output_rows(ito, flat, POINTS[:1]).any()


def test_generator_of_an_ou_process_counts_degrees():
    """In the polynomials of its stationary law the generator of dx = -x dt + sigma dW is diag(0, -1, -2, ...)."""
    stationary = replace(OU, chart=replace(OU.chart, axes=(Line(0.0, 0.7 / np.sqrt(2.0)),)))
    G = generator(*require_chart(stationary), chart_basis(stationary.chart, line=8))
    assert np.abs(G - np.diag(-np.arange(8.0))).max() < 1e-12


def test_semigroup_of_the_free_pendulum_has_its_moments():
    """The semigroup exp(t G) gives E r_2, E v_1, E v_2, E |v|^2 and E r_1^2 of the Gaussian angle to ten digits."""
    pendulum = plane_pendulum()
    basis = chart_basis(pendulum.chart, 5, 24)
    parts = pendulum.ito().parts(embed(basis.nodes))
    exact = free_moments(0.5)
    functions = basis.project(np.stack([pendulum.observables[name](0.5, parts) for name in exact], axis=1))
    start = basis.values(np.array([[0.5], [0.5]]))[:, 0]
    found = start @ expm(0.5 * generator(*require_chart(pendulum), basis)) @ functions
    assert np.allclose(found, list(exact.values()), rtol=0.0, atol=1e-10)
