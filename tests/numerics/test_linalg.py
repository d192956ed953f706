"""Small linear algebra, paths last, against exact integers and numpy.linalg."""

import numpy as np
import pytest

from facade import all_finite
from sdaeverify.numerics import (
    apply,
    apply_transposed,
    determinant,
    norm,
    product_transposed,
    solve,
)

EPS = np.finfo(float).eps
PATHS = 200


def integers(*shape, seed=1):
    """Return random integers as floats: products and sums of them are exact."""
    return np.random.default_rng(seed).integers(-9, 10, shape).astype(float)


def conditions(A):
    """Return the condition number of each path's matrix."""
    return np.linalg.cond(np.moveaxis(A, -1, 0))


def regular(m, paths=PATHS):
    """Return integer matrices (m, m, P) with condition numbers below 1e3."""
    A = integers(m, m, 4 * paths)
    return A[..., conditions(A) < 1e3][..., :paths]


@pytest.mark.parametrize("width", [1, 4])
def test_products_are_those_of_each_path(width):
    """A x, A^T y and A B^T are exact on integers, also for a matrix that is the same on all paths."""
    A, B, x, y = integers(2, 3, width), integers(4, 3, width), integers(3, 4), integers(2, 4)
    for p in range(4):
        a, b = A[..., p % width], B[..., p % width]
        assert np.array_equal(apply(A, x)[:, p], a @ x[:, p])
        assert np.array_equal(apply_transposed(A, y)[:, p], a.T @ y[:, p])
        assert np.array_equal(product_transposed(A, B)[..., p % width], a @ b.T)


@pytest.mark.parametrize("m", [1, 2, 3, 5])
@pytest.mark.parametrize("paths", [1, PATHS])
def test_solutions_are_as_good_as_the_condition_allows(m, paths):
    """With an exact integer solution the error is a few m^2 eps times the condition number."""
    A = regular(m, paths)
    x = integers(m, A.shape[-1], seed=2)
    b = np.einsum("ijp,jp->ip", A, x)
    bound = 4 * m**2 * EPS * conditions(A) * np.linalg.norm(x, axis=0)
    assert (np.linalg.norm(solve(A, b) - x, axis=0) <= bound).all()


@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_one_matrix_for_all_paths_is_enough(m):
    """A matrix (m, m, 1) is solved against every path's right-hand side."""
    A, b = regular(m, 1), integers(m, 6)
    repeated = solve(np.repeat(A, 6, axis=-1), b)
    found = solve(A, b)
    np.testing.assert_allclose(found, repeated, rtol=1e-13, atol=1e-14)
    assert np.array_equal(solve(A, b[:, :1]), found[:, :1])
    with np.errstate(all="ignore"):
        assert not np.isfinite(solve(0.0 * A, b)).any()


@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_determinants_agree_with_exact_ones(m):
    """Integer determinants are met within m^2 eps of Hadamard's bound."""
    A = regular(m)
    exact = np.round(np.linalg.det(np.moveaxis(A, -1, 0)))
    hadamard = np.prod(np.linalg.norm(A, axis=1), axis=0)
    assert (np.abs(determinant(A) - exact) <= m**2 * EPS * hadamard).all()


def with_bad_path(m, bad):
    """Return regular systems and the same ones with a bad matrix put in as path 1."""
    A, b = regular(m, 6), integers(m, 6)
    return A, np.insert(A, 1, bad, axis=-1), b, np.insert(b, 1, 1.0, axis=-1)


@pytest.mark.parametrize("m", [1, 2, 3, 5])
@pytest.mark.parametrize("bad", [0.0, np.nan], ids=["zero", "nan"])
def test_a_singular_path_spoils_itself_only(m, bad):
    """A path without a solution gets non-finite numbers, the others the same bits as without it."""
    A, disturbed, b, right = with_bad_path(m, bad)
    with np.errstate(all="ignore"):
        x = solve(disturbed, right)
    assert not np.isfinite(x[:, 1]).any()
    assert np.array_equal(np.delete(x, 1, axis=1), solve(A, b))


@pytest.mark.parametrize("m", [2, 3, 5])
def test_a_rank_deficient_path_spoils_itself_only(m):
    """Equal rows are found as well as a matrix of zeros."""
    A, disturbed, b, right = with_bad_path(m, np.ones((m, m)))
    right[0, 1] = 2.0
    with np.errstate(all="ignore"):
        x = solve(disturbed, right)
    assert not np.isfinite(x[:, 1]).all()
    assert np.array_equal(np.delete(x, 1, axis=1), solve(A, b))


def test_singular_paths_are_found_by_their_pivots_not_by_their_determinants():
    """A determinant of inf * 0 hides no zero pivot, and one that underflows condemns no regular matrix."""
    tiny, mixed = 1e-150 * np.eye(3), np.diag([np.inf, 0.0, 1.0])
    x = solve(np.stack([tiny, mixed, np.eye(3)], axis=-1), np.ones((3, 3)))
    assert np.allclose(x[:, 0], 1e150, rtol=4 * EPS)
    assert np.isnan(x[:, 1]).all()
    assert np.array_equal(x[:, 2], np.ones(3))


def test_norm_is_the_euclidean_one():
    """The norm of integers is the correctly rounded root of an exact sum."""
    x = integers(3, 50)
    assert np.array_equal(norm(x), np.sqrt((x**2).sum(axis=0)))


def test_a_path_is_finite_if_all_its_components_are():
    """NaN, infinity and opposite infinities are seen on their own path."""
    x = np.array([[1.0, np.nan, np.inf, np.inf], [2.0, 1.0, 1.0, -np.inf]])
    with np.errstate(invalid="ignore"):
        assert all_finite(x).tolist() == [True, False, False, False]
