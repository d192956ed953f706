"""Newton's method on many paths: known roots, failures that stay at home, and counts."""

import numpy as np
import pytest

from sdaeverify.numerics import newton, update_tolerance

EPS = np.finfo(float).eps
TOLERANCE = 1e-9


def square_minus(a):
    """Return F(x) = x^2 - a with its derivative, one number a path."""
    return lambda x: (x**2 - a, 2.0 * x[None])


def cube_roots_of_one(x):
    """Return z^3 - 1 for z = x_0 + i x_1 as a real system, with its derivative."""
    z = x[0] + 1j * x[1]
    value, slope = z**3 - 1.0, 3.0 * z**2
    return np.stack([value.real, value.imag]), np.array([[slope.real, -slope.imag], [slope.imag, slope.real]])


def test_square_roots_are_found_to_rounding():
    """The last update is below the tolerance, so that its square, the error, is below rounding."""
    a = np.array([4.0, 2.0, 1e-2, 9.0])
    root = newton(square_minus(a), np.full((1, 4), 3.0), TOLERANCE)
    assert root.converged.all()
    assert (np.abs(root.x[0] - np.sqrt(a)) <= 4 * EPS * np.sqrt(a)).all()


def test_the_root_of_a_system_depends_on_the_starting_point():
    """Each path of the complex cubic finds the root next to it."""
    angles = 2 * np.pi * np.arange(3) / 3
    expected = np.stack([np.cos(angles), np.sin(angles)])
    root = newton(cube_roots_of_one, expected + 0.1, TOLERANCE)
    assert root.converged.all()
    assert np.abs(root.x - expected).max() <= 8 * EPS


def test_a_path_without_root_is_reported_and_disturbs_nobody():
    """x^2 = -1 does not converge; its neighbours have the bits they have without it."""
    a, start = np.array([4.0, -1.0, 2.0]), np.full((1, 3), 3.0)
    root = newton(square_minus(a), start, TOLERANCE)
    alone = newton(square_minus(a[[0, 2]]), start[:, [0, 2]], TOLERANCE)
    assert root.converged.tolist() == [True, False, True]
    assert np.array_equal(root.x[:, [0, 2]], alone.x)
    assert np.array_equal(root.iterations[[0, 2]], alone.iterations)
    assert root.iterations[1] == 30


def test_a_batch_of_systems_is_its_paths_one_by_one():
    """Paths that need different numbers of updates do not influence each other."""
    start = np.array([[1.1, -0.4, -0.7, 5.0], [0.1, 1.0, -0.6, 3.0]])
    batch = newton(cube_roots_of_one, start, TOLERANCE)
    for p in range(4):
        one = newton(cube_roots_of_one, start[:, p : p + 1], TOLERANCE)
        assert np.array_equal(one.x[:, 0], batch.x[:, p])
        assert one.iterations[0] == batch.iterations[p]
    assert len(set(batch.iterations.tolist())) > 1


@pytest.mark.parametrize("start", [0.0, np.nan], ids=["singular", "nan"])
def test_a_singular_start_fails_on_its_path_only(start):
    """Division by zero and NaN end as a failure of their path."""
    x = np.array([[3.0, start]])
    with np.errstate(all="ignore"):
        root = newton(square_minus(np.array([4.0, 4.0])), x, TOLERANCE)
    assert root.converged.tolist() == [True, False]
    assert root.x[0, 0] == 2.0


def test_updates_are_counted():
    """A linear equation takes one update and one to confirm it; at the root the confirmation suffices."""
    root = newton(lambda x: (2.0 * x - 2.0, np.full((1, 1, 2), 2.0)), np.array([[5.0, 1.0]]), TOLERANCE)
    assert root.iterations.tolist() == [2, 1]
    assert root.x.tolist() == [[1.0, 1.0]]


def test_the_number_of_updates_is_limited():
    """A triple root converges linearly by 2/3 and is not there after five updates."""
    root = newton(lambda x: (x**3, 3.0 * x[None] ** 2), np.ones((1, 1)), TOLERANCE, max_iterations=5)
    assert not root.converged.any()
    assert root.iterations.tolist() == [5]
    assert root.x[0, 0] == pytest.approx((2 / 3) ** 5, rel=32 * EPS)


def test_the_starting_point_is_not_written_into():
    """Newton's method returns new arrays."""
    start = np.full((1, 2), 3.0)
    start.flags.writeable = False
    newton(square_minus(np.array([4.0, 2.0])), start, TOLERANCE)
    assert start.tolist() == [[3.0, 3.0]]


def test_the_tolerance_of_an_update_follows_the_largest_size() -> None:
    """Of all that is given, path by path; it is absolute where all of it is 0."""
    tolerance = update_tolerance(np.array([0.0, 2.0, 0.0]), np.array([3.0, 1.0, 0.0]))
    assert tolerance == pytest.approx([3e-9, 2e-9, 1e-9], rel=1e-15)


def asked(f, counts):
    """Return F with its derivative on request, and count the requests."""

    def lazy(x):
        value, matrix = f(x)

        def derivative():
            counts.append(1)
            return matrix

        return value, derivative

    return lazy


def test_an_affine_function_is_differentiated_once():
    """The update that finds rounding alone is made with the derivative before, and is the same."""
    A, b = np.array([[2.0, 1.0], [-1.0, 3.0]])[..., None] * np.ones(3), np.arange(6.0).reshape(2, 3)
    counts = []
    affine = lambda x: (np.einsum("mnp,np->mp", A, x) - b, A)  # noqa: E731
    lazy, eager = (
        newton(asked(affine, counts), np.zeros((2, 3)), TOLERANCE),
        newton(affine, np.zeros((2, 3)), TOLERANCE),
    )
    assert len(counts) == 1
    assert np.array_equal(lazy.x, eager.x)
    assert lazy.iterations.tolist() == eager.iterations.tolist() == [2, 2, 2]


def test_derivatives_on_request_give_the_same_roots_path_by_path():
    """What is left out changes no root by more than rounding, no count, and no neighbour."""
    counts, start = [], np.array([[1.1, -0.4, -0.7, 5.0], [0.1, 1.0, -0.6, 3.0]])
    lazy, eager = (
        newton(asked(cube_roots_of_one, counts), start, TOLERANCE),
        newton(cube_roots_of_one, start, TOLERANCE),
    )
    assert np.abs(lazy.x - eager.x).max() <= EPS
    assert np.array_equal(lazy.iterations, eager.iterations)
    assert len(counts) <= eager.iterations.max()
    for p in range(4):
        one = newton(asked(cube_roots_of_one, []), start[:, p : p + 1], TOLERANCE)
        assert np.array_equal(one.x[:, 0], lazy.x[:, p])


def test_a_path_without_root_is_none_with_derivatives_on_request_either():
    """Where F falls while the update stays large, nothing is accepted."""
    root = newton(asked(square_minus(np.array([4.0, -1.0])), []), np.full((1, 2), 3.0), TOLERANCE)
    assert root.converged.tolist() == [True, False]
