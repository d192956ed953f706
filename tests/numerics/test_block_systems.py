"""Systems of block-banded matrices: their solution, and that no path depends on another."""

import numpy as np
import pytest

from numerics.random_blocks import banded, dense
from sdaeverify.numerics import BlockBanded, solve_blocks

EPS = np.finfo(float).eps


def saddle(N, paths):
    """Return the parts of a system with zeros on its diagonal, as constraints give it, and right-hand sides."""
    A, B = banded((N, 3, 3), 2, 1, paths), banded((N, 1, 3), 1, 0, paths, seed=1)
    right = np.random.default_rng(2).standard_normal((N, 4, paths))
    return ((A, B.transposed()), (B, None)), (right[:, :3], right[:, 3:])


def written_out(rows, right):
    """Return the same system as matrices, the rows of one equation after those of the other."""
    (A, C), (B, _) = ([None if part is None else dense(part) for part in row] for row in rows)
    zero = np.zeros((B.shape[0], C.shape[1], B.shape[2]))
    matrix = np.block([[np.moveaxis(x, -1, 0) for x in row] for row in ((A, C), (B, zero))])
    return matrix, np.concatenate([x.reshape(-1, x.shape[-1]) for x in right]).T


def some(rows, paths):
    """Return a system on some of its paths."""
    return [
        [None if part is None else BlockBanded(part.blocks[..., paths], part.lower) for part in row] for row in rows
    ]


@pytest.mark.parametrize("N", [1, 2, 3, 9])
def test_the_solution_is_that_of_the_matrix(N):
    """Each path solves its own system, up to rounding errors of its condition."""
    rows, right = saddle(N, 6)
    matrix, b = written_out(rows, right)

    found = np.concatenate([y.reshape(-1, 6) for y in solve_blocks(rows, right)]).T

    for p in range(6):
        size = np.abs(found[p]).max()
        assert (
            np.abs(found[p] - np.linalg.solve(matrix[p], b[p])).max() <= 64 * EPS * np.linalg.cond(matrix[p]) * size
        )


def test_matrices_may_be_the_same_on_all_paths():
    """A matrix given once is that of every path."""
    A, x = banded((6, 2, 2), 1, 1, paths=1), np.random.default_rng(5).standard_normal((6, 2, 4))

    (once,) = solve_blocks([[A]], [x])
    (often,) = solve_blocks([[BlockBanded(np.repeat(A.blocks, 4, axis=-1), 1)]], [x])

    assert np.array_equal(once, often)


@pytest.mark.parametrize("paths", [[7], [11, 3, 5], list(range(11, -1, -1))])
def test_a_path_is_solved_the_same_in_any_company(paths):
    """Alone, among few and in another order, a path has the same solution to the last bit."""
    rows, right = saddle(9, 12)

    everywhere = solve_blocks(rows, right)
    here = solve_blocks(some(rows, paths), [x[..., paths] for x in right])

    for one, other in zip(everywhere, here, strict=True):
        assert np.array_equal(one[..., paths], other)


def test_many_paths_are_solved_like_few():
    """More paths than are eliminated together have the solutions of the first of them."""
    rows, right = saddle(9, 3)
    many = np.tile(np.arange(3), 700)

    few = solve_blocks(rows, right)
    all_of_them = solve_blocks(some(rows, many), [x[..., many] for x in right])

    for one, other in zip(few, all_of_them, strict=True):
        assert np.array_equal(one[..., many], other)


def spoiled(rows, how):
    """Spoil the system of path 2."""
    (A, C), (B, _) = rows
    changed, singular = A.blocks.copy(), B.blocks.copy()
    if how == "not finite":
        changed[2, 4, 0, 1, 2] = np.inf
    elif how == "singular":
        singular[..., 2] = 0.0
    else:
        # In node 4 elimination adds 1e308 and 1e308, which the sum of all entries never does.
        changed[:, 4, ..., 2], changed[0, 4, 2, 2, 2] = 0.0, -0.5e308
        changed[2, 4, ..., 2] = np.array([[1, -1, -1], [1, 1, 1], [0, 0, 0]]) * 1e308
    return (BlockBanded(changed, A.lower), C), (BlockBanded(singular, B.lower), None)


@pytest.mark.parametrize("how", ["not finite", "singular", "overflowing"])
def test_a_path_that_cannot_be_solved_leaves_the_others_alone(how):
    """Its own solution is not finite, theirs is what it was; to rounding, if they must be solved again."""
    rows, right = saddle(9, 6)
    tolerance = 1e-9 if how == "overflowing" else 0.0

    with np.errstate(all="ignore"):
        before, after = solve_blocks(rows, right), solve_blocks(spoiled(rows, how), right)

    for one, other in zip(before, after, strict=True):
        assert np.delete(other, 2, axis=-1) == pytest.approx(np.delete(one, 2, axis=-1), rel=tolerance, abs=0.0)
    assert not np.isfinite(np.concatenate(after, axis=1)[..., 2]).all()


def test_a_right_hand_side_that_is_not_finite_stays_on_its_path():
    """The path is lost, the others are not."""
    rows, right = saddle(9, 6)
    spoilt = [x.copy() for x in right]
    spoilt[0][3, 1, 4] = np.inf

    before, after = solve_blocks(rows, right), solve_blocks(rows, spoilt)

    for one, other in zip(before, after, strict=True):
        assert np.array_equal(np.delete(one, 4, axis=-1), np.delete(other, 4, axis=-1))
        assert np.isnan(other[..., 4]).all()
