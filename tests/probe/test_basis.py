"""Bases on charts: orthonormal, closed under derivatives, and projected onto without folding back."""

import numpy as np
import pytest

from sdaeverify import Angle, Chart, Line
from sdaeverify.probe.operator import basis as bases
from sdaeverify.probe.operator.basis import chart_basis, fourier, hermite

EPS = np.finfo(float).eps
AXES = {"fourier": fourier(9), "hermite": hermite(9, Line(0.3, 0.7))}
POINTS = np.linspace(-2.0, 2.0, 7)


def chart(*axes):
    return Chart(axes, lambda z: z, lambda x: x)


PLANE = chart(Angle(), Line(-0.2, 1.5))


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_functions_of_a_coordinate_are_orthonormal(axis):
    """<phi_i, phi_j> = delta_ij for the law of the weights, which have sum 1."""
    values = axis.values(axis.nodes)
    # Hermite polynomials reach 1e3 at the outermost nodes, where weights are known to rounding.
    assert np.abs((values * axis.weights) @ values.T - np.eye(9)).max() < 1e3 * EPS
    assert axis.weights.sum() == pytest.approx(1.0, abs=16 * EPS)


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_derivatives_stay_in_the_basis(axis):
    """phi_j' = sum_i D_ij phi_i agrees with central differences."""
    step = EPS ** (1 / 3)
    central = (axis.values(POINTS + step) - axis.values(POINTS - step)) / (2 * step)
    assert np.abs(axis.derivative.T @ axis.values(POINTS) - central).max() < 1e-6


def test_functions_are_the_named_ones():
    """The third of an angle is sqrt(2) sin y, the third of a line (x^2 - 1)/sqrt(2), x = (y - centre)/scale."""
    x = (POINTS - 0.3) / 0.7
    assert np.allclose(AXES["fourier"].values(POINTS)[2], np.sqrt(2.0) * np.sin(POINTS), rtol=0.0, atol=8 * EPS)
    assert np.allclose(AXES["hermite"].values(POINTS)[2], (x**2 - 1) / np.sqrt(2.0), rtol=32 * EPS, atol=32 * EPS)


def test_a_product_is_recovered_from_its_values_at_the_nodes():
    """Projection of a function of the basis gives its coefficients, the constant coming first."""
    basis = chart_basis(PLANE, 5, 4)
    given = np.sin(np.arange(20.0))
    found = basis.project(basis.values(basis.nodes).T @ given)
    assert np.abs(found - given).max() < 1e2 * EPS
    assert np.array_equal(basis.values(basis.nodes)[0], np.ones(basis.nodes.shape[1]))


@pytest.mark.parametrize("axis", [Angle(), Line(1.0, 2.0)], ids=["angle", "line"])
def test_a_chart_of_one_coordinate_has_its_functions_only(axis):
    """The missing coordinate adds nothing, neither functions nor nodes."""
    basis = chart_basis(chart(axis), 7, 7)
    assert basis.values(np.zeros((1, 3))).shape == (7, 3)
    assert basis.nodes.shape == (1, 11)
    assert basis.weights.sum() == pytest.approx(1.0, abs=16 * EPS)


def test_several_functions_are_projected_at_once():
    """Coefficients of a matrix of values are those of its columns."""
    basis = chart_basis(PLANE, 5, 4)
    values = np.cos(np.outer(np.arange(basis.nodes.shape[1]), [0.1, 0.2, 0.3]))
    assert np.allclose(basis.project(values)[:, 1], basis.project(values[:, 1]), rtol=0.0, atol=8 * EPS)


def test_more_nodes_than_functions_keep_what_is_beyond_the_basis_out(monkeypatch):
    """The functions up to cos 4y have no share of cos 6y, which passes for cos 3y with as many nodes as functions."""
    oversampled = fourier(9)
    monkeypatch.setattr(bases, "OVERSAMPLING", 1.0)
    interpolating = fourier(9)
    shares = [axis.projection @ np.cos(6 * axis.nodes) for axis in (oversampled, interpolating)]
    assert np.abs(shares[0]).max() < 16 * EPS
    assert shares[1][5] == pytest.approx(1 / np.sqrt(2.0), abs=16 * EPS)
