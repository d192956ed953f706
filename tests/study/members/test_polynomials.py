"""Random polynomials, of which the coefficients of random members are made."""

import numpy as np
import pytest

from facade import Polynomial, draw_polynomial, draw_regular, monomials_of

STEP = 1e-30


@pytest.fixture
def rng():
    """Return a generator of fixed seed."""
    return np.random.default_rng(7)


@pytest.fixture
def cubic(rng):
    """Return a random cubic map R^3 -> R^2 about a point that is not the origin."""
    return draw_polynomial(rng, np.array([0.5, -1.0, 2.0]), 2)


def test_values_are_sums_of_monomials(rng, cubic):
    """The value is the sum of coefficients times products of the distances from the centre."""
    z = rng.standard_normal((3, 4))
    u = z - cubic.centre[:, None]
    products = np.array([np.prod([u[k] for k in powers], axis=0) * np.ones(4) for powers in cubic.powers])
    assert len(cubic.powers) == len(monomials_of(3, 3)) == 20
    assert np.allclose(cubic(z), cubic.coefficients @ products, rtol=1e-14)


def test_derivatives_are_those_of_complex_steps(rng, cubic):
    """First, second and third derivatives agree with complex steps up to rounding."""
    z, f = rng.standard_normal((3, 4)), cubic
    for _ in range(3):
        steps = [f(z + 1j * STEP * np.eye(3)[:, k : k + 1]).imag / STEP for k in range(3)]
        assert np.allclose(f.derivative(z), np.stack(steps, axis=1).reshape(-1, 4), rtol=1e-12, atol=1e-13)
        f = f.derivative
    assert f.powers == ((),)


def test_terms_are_left_out_by_variable_and_by_degree(rng, cubic):
    """A polynomial without a variable is constant in it, and one up to degree 1 is affine."""
    z = rng.standard_normal((3, 4))
    moved = z + np.array([[0.0], [1.0], [0.0]])
    assert np.array_equal(cubic.without(1)(z), cubic.without(1)(moved))
    assert not np.allclose(cubic(z), cubic(moved))
    affine = cubic.up_to(1)
    assert np.allclose(affine(z) + affine(-z), 2.0 * affine(0.0 * z))
    assert isinstance(affine, Polynomial)


def test_no_coefficient_is_near_zero(cubic):
    """Coefficients of degree k are at least 0.2 n^(-(k - 1)/2) in size, with both signs."""
    sizes = np.array([3.0 ** (-0.5 * max(len(powers) - 1, 0)) for powers in cubic.powers])
    relative = np.abs(cubic.coefficients) / sizes
    assert relative.min() >= 0.2
    assert relative.max() <= 0.5
    assert {*np.sign(cubic.coefficients).ravel()} == {-1.0, 1.0}


@pytest.mark.parametrize("shape", [(2, 4), (3, 3), (4, 2)])
def test_regular_matrices_have_singular_values_from_1_to_2(rng, shape):
    """Linear parts that must be regular are far from singular ones."""
    values = np.linalg.svd(draw_regular(rng, *shape), compute_uv=False)
    assert values.min() >= 1.0 - 1e-12
    assert values.max() <= 2.0 + 1e-12
