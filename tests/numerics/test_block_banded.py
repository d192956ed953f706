"""Block-banded matrices do what the matrices do that they stand for."""

import numpy as np
import pytest

from numerics.random_blocks import banded, dense
from sdaeverify.numerics import BlockBanded

CASES = [(1, 1, 2), (2, 2, 1), (3, 1, 1), (7, 2, 1)]
P = 4


@pytest.mark.parametrize(("N", "lower", "upper"), CASES)
def test_products_and_sums_are_those_of_the_matrices(N, lower, upper):
    """Product, sum, difference, multiple and transpose, also of matrices that are the same on all paths."""
    A, B = banded((N, 3, 2), lower, upper), banded((N, 2, 4), 1, 2, seed=1)
    C = banded((N, 3, 2), 0, 1, paths=1, seed=2)

    assert dense(A @ B) == pytest.approx(np.einsum("abp,bcp->acp", dense(A), dense(B)))
    assert dense(A + np.float64(2.0) * C) == pytest.approx(dense(A) + 2.0 * dense(C))
    assert dense(C - A) == pytest.approx(dense(C) - dense(A))
    assert np.array_equal(dense(A.transposed()), np.swapaxes(dense(A), 0, 1))


@pytest.mark.parametrize(("N", "lower", "upper"), CASES)
def test_a_matrix_acts_on_vectors_by_nodes(N, lower, upper):
    """A x and the norm of A for largest components are those of the matrix."""
    A = banded((N, 3, 2), lower, upper)
    x = np.random.default_rng(3).standard_normal((N, 2, P))

    assert A.times(x).reshape(-1, P) == pytest.approx(np.einsum("abp,bp->ap", dense(A), x.reshape(-1, P)))
    assert A.size() == pytest.approx(np.abs(dense(A)).sum(axis=1).max(axis=0))


def test_the_identity_changes_nothing():
    """The identity is that of all products."""
    A = banded((5, 3, 3), 1, 1)

    assert np.array_equal(dense(BlockBanded.identity(5, 3) @ A), dense(A))
    assert np.array_equal(dense(BlockBanded.identity(5, 3))[..., 0], np.eye(15))
