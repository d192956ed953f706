"""Elimination without pivoting on every path at once, and what it does where pivots are small."""

import numpy as np
import pytest

from facade import eliminated

EPS = float(np.finfo(float).eps)


def matrices(m, paths=40, skew=0.0):
    """Return positive definite matrices with a skew part, shape (m, m, P)."""
    rng = np.random.default_rng(m)
    J, K = rng.standard_normal((2, paths, m, 2 * m))
    S = K[..., :m] - np.swapaxes(K[..., :m], 1, 2)
    return np.moveaxis(J @ np.swapaxes(J, 1, 2) + skew * S, 0, -1)


@pytest.mark.parametrize("skew", [0.0, 0.5])
@pytest.mark.parametrize("m", [1, 2, 3, 6, 15])
def test_systems_are_solved(m, skew):
    """Residuals are rounding for one right side and for several, and the factors were good enough."""
    A = matrices(m, skew=skew)
    b = np.random.default_rng(0).standard_normal((m, 3, 40))
    factors = eliminated(A)

    x = factors.solve(b)

    size = np.abs(A).max(axis=(0, 1)) * np.abs(x).max(axis=(0, 1))
    assert not factors.poor.any()
    assert np.all(np.abs(np.einsum("ijp,jkp->ikp", A, x) - b).max(axis=(0, 1)) <= 32 * m * EPS * size)
    assert np.allclose(factors.solve(b[:, 0]), x[:, 0], rtol=1e-12)


def test_small_pivots_are_noticed_and_solved_with_pivoting():
    """Where the first pivot vanishes or nearly so, the solution is as accurate as elsewhere."""
    A = matrices(4)
    A[0, 0, 3], A[0, 0, 7] = 0.0, 1e-13
    b = np.ones((4, 40))
    factors = eliminated(A)

    x = factors.solve(b)

    assert np.flatnonzero(factors.poor).tolist() == [3, 7]
    residual = np.abs(np.einsum("ijp,jp->ip", A, x) - b).max(axis=0)
    assert np.all(residual <= 128 * EPS * np.abs(A).max(axis=(0, 1)) * np.abs(x).max(axis=0))


def test_a_singular_matrix_spoils_its_own_path_only():
    """The other paths are solved as if it were not there."""
    A = matrices(3)
    expected = eliminated(A).solve(np.ones((3, 40)))
    A[..., 5] = 1.0

    x = eliminated(A).solve(np.ones((3, 40)))

    assert not np.isfinite(x[:, 5]).all()
    others = np.arange(40) != 5
    assert np.array_equal(x[:, others], expected[:, others])


@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_the_sign_of_the_determinant(m):
    """Positive where an even number of rows is turned round, and nowhere where it is singular or NaN."""
    A = matrices(m, skew=0.3)
    A[0, :, ::2] *= -1.0
    A[..., 1], A[..., 3] = 0.0, np.nan

    expected = np.arange(40) % 2 == 1
    expected[[1, 3]] = False
    assert np.array_equal(eliminated(A).positive(), expected)
