"""Derivatives by complex step against derivatives worked out by hand."""

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import jacobian_at_once
from sdaeverify.numerics import directional, is_analytic, jacobian, second_directional

EPS = np.finfo(float).eps

points = hnp.arrays(float, (2, 3), elements=st.floats(-2.0, 2.0, allow_subnormal=False))
small = hnp.arrays(float, (2, 3), elements=st.floats(-1.0, 1.0, allow_subnormal=False))
X = np.array([[0.3, -0.7, 1.1], [0.2, 0.5, -0.4]])
Y = np.array([[1.0, -0.5, 0.25], [0.5, 2.0, -1.0]])
Z = np.array([[-0.3, 0.8, 1.0], [0.9, 0.1, 0.7]])


def f(x):
    """Return (x_0^3 + 2 x_0 x_1, sin(x_0) exp(x_1))."""
    return np.stack([x[0] ** 3 + 2.0 * x[0] * x[1], np.sin(x[0]) * np.exp(x[1])])


def exact_jacobian(x):
    """Return the Jacobian of f, shape (2, 2, P)."""
    e = np.exp(x[1])
    return np.array([[3.0 * x[0] ** 2 + 2.0 * x[1], 2.0 * x[0]], [np.cos(x[0]) * e, np.sin(x[0]) * e]])


def exact_second(x, y, z):
    """Return D^2 f(x)(y, z), shape (2, P)."""
    e, mixed = np.exp(x[1]), y[0] * z[1] + y[1] * z[0]
    second = np.sin(x[0]) * (y[1] * z[1] - y[0] * z[0]) + np.cos(x[0]) * mixed
    return np.stack([6.0 * x[0] * y[0] * z[0] + 2.0 * mixed, e * second])


# |f| and |Df| are below 25 for components in [-2, 2]; a dozen roundings of numbers that size.
ROUNDING = 12 * EPS * 25


@given(x=points)
def test_jacobian_is_exact_to_rounding(x):
    """The complex step has no truncation error on polynomials, sines and exponentials."""
    assert np.abs(jacobian(f, x) - exact_jacobian(x)).max() <= ROUNDING


@given(x=points, y=points)
def test_directional_derivative_is_the_jacobian_times_the_direction(x, y):
    """Df(x) y agrees with the Jacobian worked out by hand."""
    expected = np.einsum("mnp,np->mp", exact_jacobian(x), y)
    assert np.abs(directional(f, x, y) - expected).max() <= 4 * ROUNDING


def test_directional_derivative_keeps_the_shape_of_a_matrix_valued_function():
    """A diffusion matrix (d, l, P) has a derivative of the same shape."""

    def B(x):
        return np.stack([f(x), 2.0 * f(x), x], axis=1)

    derivative = directional(B, X, Y)
    assert derivative.shape == (2, 3, 3)
    assert np.array_equal(derivative[:, 1], 2.0 * derivative[:, 0])
    assert np.array_equal(derivative[:, 2], Y)


def test_derivatives_of_one_path_do_not_depend_on_the_others():
    """A batch gives bit for bit what its paths give one by one."""
    batch, second = jacobian(f, X), second_directional(f, X, Y, Z)
    for k in range(3):
        one = slice(k, k + 1)
        assert np.array_equal(jacobian(f, X[:, one]), batch[..., one])
        assert np.array_equal(second_directional(f, X[:, one], Y[:, one], Z[:, one]), second[:, one])


@pytest.mark.parametrize("paths", [1, 3, 64, 5000])
def test_directions_side_by_side_change_no_bit_of_a_jacobian(paths):
    """Few paths or many, and a function of one column for all of them: both give the same array."""
    x = np.random.default_rng(1).standard_normal((2, paths))
    assert np.array_equal(jacobian_at_once(f, x), jacobian(f, x))
    constant = np.array([[1.0], [2.0]])
    assert np.array_equal(jacobian_at_once(lambda _: constant, x), jacobian(lambda _: constant, x))


def test_a_jacobian_can_be_differentiated_once_more():
    """The complex step of a Jacobian that was itself taken by complex steps is the second derivative."""
    derivative = directional(lambda x: jacobian(f, x), X, Y)
    for k, unit in enumerate(np.eye(2)):
        expected = exact_second(X, np.repeat(unit[:, None], 3, axis=1), Y)
        assert (np.abs(derivative[:, k] - expected) <= 1e-10 * np.abs(Y).max(axis=0)).all()


def test_a_single_state_without_path_axis_has_a_jacobian():
    """The functions serve one state (n,) as well as a batch (n, P)."""
    assert np.abs(jacobian(f, X[:, 0]) - exact_jacobian(X[:, :1])[..., 0]).max() <= ROUNDING


# With components in [-1, 1], directions scaled to size 1 and |w_i| <= 2, the sixth derivative along w is at most
# 8^3 e (exponential part; the cubic has none): truncation 8^3 e 1e-12/360 < 4e-12 for each of two squares, times
# 1/4. Rounding: imaginary parts below 0.02, a dozen roundings each, four of them, times 1/4 over 1e-6: 6e-11.
SECOND_ERROR = 2e-12 + 12 * EPS * 0.02 / 1e-6


@pytest.mark.long
@given(x=small, y=small, z=small)
def test_second_derivative_is_within_its_stated_error(x, y, z):
    """Truncation is of order s^4 and rounding of order eps/s, relative to the directions."""
    error = np.abs(second_directional(f, x, y, z) - exact_second(x, y, z))
    size = np.abs(y).max(axis=0) * np.abs(z).max(axis=0)
    assert (error <= SECOND_ERROR * size + np.finfo(float).tiny).all()


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("length", ["own", "one"])
def test_second_derivative_is_as_good_in_other_units(size, length):
    """Whether f changes over lengths of the size of x or over 1: one step or the other lost all digits."""
    x, unit = size * X, size if length == "own" else 1.0

    def of_units(z):
        return f(z / unit) if length == "own" else f((z - x) + X)

    found = unit**2 * second_directional(of_units, x, Y, Z)

    # Where f changes over 1, the difference of x from itself is rounded to eps size.
    rounding = 1e-6 if length == "own" else 1e-6 + 1e3 * EPS * size / 1e-3
    assert np.abs(found - exact_second(X, Y, Z)).max() <= rounding


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-6, 1e-3, 1.0])
def test_a_function_is_analytic_in_other_units(size):
    """A sine over lengths of 1e-6 is analytic near 0 and at 1e-6; an absolute value beside 1 is not."""
    x = np.full((2, 2), size)
    smooth, kinked = (lambda z: np.sin(z / 1e-6)), (lambda z: 1.0 + np.abs(z))

    assert is_analytic(smooth, x) or size > 1e-6
    assert not is_analytic(kinked, x)


def test_second_derivative_of_a_quadratic_is_rounded_only():
    """Without truncation the error of D^2 (1 - |x|^2)/2 is that of four imaginary parts below 3e-3, over 1e-6."""
    x, y, z = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 2, 1000))
    computed = second_directional(lambda x: 0.5 - 0.5 * (x[0] ** 2 + x[1] ** 2), x, y, z)
    size = np.abs(y).max(axis=0) * np.abs(z).max(axis=0)
    # Four roundings of eps/2 each, four evaluations, times 1/4.
    assert (np.abs(computed + (y * z).sum(axis=0)) <= 4 * EPS / 2 * 3e-3 / 1e-6 * size).all()


@pytest.mark.parametrize(("a", "b"), [(2.0**20, 2.0**20), (2.0**-30, 2.0**-20), (2.0**20, 2.0**-20)])
def test_second_derivative_is_bilinear_in_the_size_of_its_directions(a, b):
    """A fast or slow velocity does not change the step: powers of two go through bit for bit."""
    assert np.array_equal(second_directional(f, X, a * Y, b * Z), a * b * second_directional(f, X, Y, Z))


def test_second_derivative_in_no_direction_is_zero():
    """A path at rest has no curvature term."""
    assert np.array_equal(second_directional(f, X, 0.0 * Y, 0.0 * Y), np.zeros((2, 3)))


@pytest.mark.parametrize(
    "function",
    [
        f,
        lambda x: x**2 + 1e8,
        lambda x: np.sin(100.0 * x),
        lambda x: np.sqrt(2.0 + x),
        lambda x: 1.0 / (3.0 + x),
        lambda x: np.ones((1, 1, x.shape[-1])),
        lambda x: np.maximum(x, -10.0),
    ],
)
def test_analytic_functions_are_recognised(function):
    """Large constants, fast oscillations and constant functions do not count as errors."""
    assert is_analytic(function, X)
    assert is_analytic(function, 0.0 * X)


def test_large_states_are_no_obstacle():
    """The difference step grows with the state, so that it is not lost in its rounding."""
    assert is_analytic(lambda x: x**2, 1e9 * X)


def into_real_buffer(x):
    """Copy a square into a buffer that cannot hold an imaginary part."""
    out = np.zeros(x.shape)
    out[...] = x**2
    return out


NOT_ANALYTIC = [
    np.abs,
    np.conj,
    np.real,
    np.floor,
    into_real_buffer,
    lambda x: (x * np.conj(x)).real,
    lambda x: np.linalg.norm(x, axis=0)[None],
]


@pytest.mark.parametrize("function", NOT_ANALYTIC)
@pytest.mark.parametrize("x", [X, np.zeros((2, 1)), np.array([[1.0], [0.0]])], ids=["inside", "origin", "axis"])
def test_functions_that_break_the_complex_step_are_recognised(function, x):
    """Moduli, conjugates and real buffers are noticed, even where their derivative happens to vanish."""
    assert not is_analytic(function, x)
