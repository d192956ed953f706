"""The structure of a problem in which everything may couple with everything: one node of all positions."""

from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...numerics import BlockBanded, directional
from .structure import Structure

if TYPE_CHECKING:
    from .holonomic import HolonomicSDAE


class Unstructured(Structure):
    """One node; derivatives along all unit vectors are taken side by side, as if they were further paths."""

    def force_blocks(self, problem: "HolonomicSDAE", t: float, r: Array, v: Array) -> tuple[BlockBanded, BlockBanded]:
        """Return the derivatives of a(t, r, v) by r and by v, blocks of shape (n, n, P) or (n, n, 1)."""
        if problem.force_derivatives is not None:
            return super().force_blocks(problem, t, r, v)
        n, P = r.shape
        sides = n * P
        x, unit = repeated(np.concatenate([r, v]), 2 * n), units(2 * n, P)
        change = directional(lambda z: problem.force(t, z[:n], z[n:]), x, unit)
        by_x = np.broadcast_to(change, (n, 2 * sides)).reshape(n, 2, n, P)
        return one_block(by_x[:, 0]), one_block(by_x[:, 1])

    def constraint_blocks(self, problem: "HolonomicSDAE", r: Array) -> BlockBanded:
        """Return Dg(r), one block of shape (m, n, P)."""
        return one_block(problem.dg(r))

    def curvature_rows(self, problem: "HolonomicSDAE", r: Array, v: Array) -> BlockBanded:
        """Return the rows v^T Hess g_j(r), one block of shape (m, n, P)."""
        n, P = r.shape
        rows = problem.d2g(repeated(r, n), repeated(v, n), units(n, P))
        return one_block(np.broadcast_to(rows, (len(rows), n * P)).reshape(-1, n, P))

    def curvature_sum(self, problem: "HolonomicSDAE", r: Array, c: Array) -> BlockBanded:
        """Return H(c) = sum_j c_j Hess g_j(r), one block of shape (n, n, P)."""
        n, P = r.shape
        x, unit, weights = repeated(r, n), units(n, P), repeated(c, n)
        rows = [
            (weights * problem.d2g(x, repeated(y, n), unit)).sum(axis=0) for y in np.eye(n)[..., None] + 0.0 * r[0]
        ]
        return one_block(np.reshape(rows, (n, n, P)))


def repeated(x: Array, times: int) -> Array:
    """Return the paths several times, shape (n, P) -> (n, times P)."""
    return np.tile(x, times)


def units(n: int, paths: int) -> Array:
    """Return the unit vectors of n components, each for all paths, shape (n, n P)."""
    return np.repeat(np.eye(n), paths, axis=1)


def one_block(matrix: Array) -> BlockBanded:
    """Return a matrix of shape (a, b, P) as one block."""
    return BlockBanded(matrix[None, None])
