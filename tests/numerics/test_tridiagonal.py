"""Tridiagonal systems against dense linear algebra."""

import numpy as np
import pytest

from sdaeverify.numerics import Tridiagonal, solve

EPS = float(np.finfo(float).eps)
M, PATHS = 9, 4


def definite() -> Tridiagonal:
    """Return a diagonally dominant matrix a path."""
    rng = np.random.default_rng(0)
    lower, upper = rng.uniform(-1.0, 1.0, (2, M - 1, PATHS))
    return Tridiagonal(lower, rng.uniform(2.5, 4.0, (M, PATHS)), upper)


def dense(A: Tridiagonal) -> np.ndarray:
    """Return the matrices, shape (m, m, P)."""
    full = np.zeros((M, M, PATHS))
    inner = np.arange(M - 1)
    full[inner + 1, inner], full[inner, inner + 1] = A.lower, A.upper
    full[np.arange(M), np.arange(M)] = A.diagonal
    return full


@pytest.mark.parametrize("shape", [(M, PATHS), (M, 3, PATHS)], ids=["vector", "matrix"])
def test_systems_are_solved(shape):
    """A x = b agrees with elimination of the full matrix, for one and for several right-hand sides."""
    A, b = definite(), np.random.default_rng(1).standard_normal(shape)
    assert np.abs(A.solve(b) - solve(dense(A), b)).max() <= 64 * EPS


def test_the_sign_of_the_determinant():
    """It is that of the full matrix's determinant, also where it would overflow; NaN is not positive."""
    A = definite()
    signs = A.diagonal * np.array([1.0, 1.0, 1.0, np.nan])
    signs[0, 1] *= -1.0
    with np.errstate(invalid="ignore"):
        determinants = np.linalg.det(np.moveaxis(dense(Tridiagonal(A.lower, signs, A.upper)), -1, 0))
    assert Tridiagonal(A.lower, signs, A.upper).positive().tolist() == (determinants > 0.0).tolist()
    huge = Tridiagonal(*(1e100 * part for part in A))
    assert huge.positive().all()


def test_no_path_depends_on_its_neighbours():
    """A path gives the same bits alone as beside others, one of which is singular."""
    A, b = definite(), np.ones((M, PATHS))
    for part in A:
        part[:, 2] = 0.0
    with np.errstate(all="ignore"):
        together = A.solve(b)
    assert not np.isfinite(together[:, 2]).any()
    alone = Tridiagonal(*(part[:, 1:2] for part in A)).solve(b[:, 1:2])
    assert np.array_equal(together[:, 1:2], alone)
