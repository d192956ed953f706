"""Block-banded matrices on every path at once, for nodes that couple with near neighbours only."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import Array, Mask
from .linalg import solve


@dataclass(frozen=True, eq=False)
class BlockBanded:
    """A matrix A of N x N blocks of shape (a, b), zero except on the block diagonals near the main one.

    Attributes
    ----------
    blocks : ndarray, shape (K, N, a, b, P) or (K, N, a, b, 1)
        ``blocks[k, i]`` is A_{i,j} with j = i + k - lower; zero where there is no node j.
    lower : int
        Number of block diagonals below the main one; K - 1 - lower are above it.
    """

    blocks: Array
    lower: int = 0

    # Without this, NumPy would evaluate number * matrix elementwise instead of calling `__rmul__`.
    __array_ufunc__ = None

    @classmethod
    def identity(cls, nodes: int, size: int) -> "BlockBanded":
        """Return the identity with blocks of shape (size, size), shared by all paths."""
        return cls(np.broadcast_to(np.eye(size)[..., None], (1, nodes, size, size, 1)))

    @property
    def upper(self) -> int:
        """Number of block diagonals above the main one."""
        return len(self.blocks) - 1 - self.lower

    def __add__(self, other: "BlockBanded") -> "BlockBanded":
        if (self.lower, self.upper) == (other.lower, other.upper):
            return BlockBanded(self.blocks + other.blocks, self.lower)
        lower, upper = max(self.lower, other.lower), max(self.upper, other.upper)
        paths = max(self.blocks.shape[-1], other.blocks.shape[-1])
        total = np.zeros((lower + upper + 1, *self.blocks.shape[1:-1], paths))
        for part in (self, other):
            total[lower - part.lower : lower + part.upper + 1] += part.blocks
        return BlockBanded(total, lower)

    def __sub__(self, other: "BlockBanded") -> "BlockBanded":
        if (self.lower, self.upper) == (other.lower, other.upper):
            return BlockBanded(self.blocks - other.blocks, self.lower)
        return self + (-1.0) * other

    def __rmul__(self, factor: float) -> "BlockBanded":
        return BlockBanded(factor * self.blocks, self.lower)

    def __matmul__(self, other: "BlockBanded") -> "BlockBanded":
        """Return the matrix product; its bandwidth is the sum of both, and at most the number of nodes."""
        A, B = self.blocks, other.blocks
        if len(A) == len(B) == 1:
            return BlockBanded(np.einsum("knabp,knbcp->knacp", A, B))
        N, paths = A.shape[1], max(A.shape[-1], B.shape[-1])
        lower, upper = min(self.lower + other.lower, N - 1), min(self.upper + other.upper, N - 1)
        product = np.zeros((lower + upper + 1, N, A.shape[2], B.shape[3], paths))
        for k in range(len(A)):
            rows, columns = overlap(N, k - self.lower)
            for j in range(len(B)):
                diagonal = k + j + lower - self.lower - other.lower
                if 0 <= diagonal < len(product):
                    product[diagonal, rows] += np.einsum("nabp,nbcp->nacp", A[k, rows], B[j, columns])
        return BlockBanded(product, lower)

    def times(self, x: Array) -> Array:
        """Return A x, shape (N, b, P) -> (N, a, P)."""
        if len(self.blocks) == 1:
            return np.asarray(np.einsum("nabp,nbp->nap", self.blocks[0], x))
        N, paths = self.blocks.shape[1], max(self.blocks.shape[-1], x.shape[-1])
        product = np.zeros((N, self.blocks.shape[2], paths))
        for k, blocks in enumerate(self.blocks):
            rows, columns = overlap(N, k - self.lower)
            product[rows] += np.einsum("nabp,nbp->nap", blocks[rows], x[columns])
        return product

    def transposed(self) -> "BlockBanded":
        """Return A^T."""
        K, N, a, b, paths = self.blocks.shape
        if K == 1:
            return BlockBanded(np.swapaxes(self.blocks, 2, 3))
        flipped = np.zeros((K, N, b, a, paths), dtype=self.blocks.dtype)
        for k, blocks in enumerate(self.blocks):
            rows, columns = overlap(N, k - self.lower)
            flipped[K - 1 - k, columns] = np.swapaxes(blocks[rows], 1, 2)
        return BlockBanded(flipped, self.upper)

    def size(self) -> Array:
        """Return the norm induced by the maximum norm: the largest absolute row sum, shape (P,) or (1,)."""
        sizes = np.abs(self.blocks)
        rows: Array = sizes[0].sum(axis=2) if len(sizes) == 1 else sizes.sum(axis=(0, 3))
        return np.asarray(np.maximum.reduce(rows, axis=(0, 1)))


def overlap(nodes: int, offset: int) -> tuple[slice, slice]:
    """Return the block rows i for which node i + offset exists, and these columns i + offset."""
    rows, columns = (slice(max(0, -o), max(0, min(nodes, nodes - o))) for o in (offset, -offset))
    return rows, columns


# Linear systems of block-banded matrices on every path at once, at a cost proportional to the number of nodes.


# Entries of the largest band matrix that is eliminated in one call: 8 MiB; larger ones are not faster.
LARGEST = 2**20


class Part(NamedTuple):
    """A matrix that fills the rows from `top` and the columns from `left` of every node's block."""

    top: int
    left: int
    matrix: BlockBanded

    def of(self, paths: Mask) -> "Part":
        """Return the part restricted to some paths."""
        blocks = self.matrix.blocks
        taken = blocks[..., paths] if blocks.shape[-1] > 1 else blocks
        return self._replace(matrix=BlockBanded(taken, self.matrix.lower))

    @property
    def place(self) -> tuple[int, ...]:
        """Position and shape of its entries, on which the layout of a system depends."""
        K, _, a, b, _ = self.matrix.blocks.shape
        return (self.top, self.left, K, self.matrix.lower, a, b)


def solve_blocks(rows: Sequence[Sequence[BlockBanded | None]], right: Sequence[Array]) -> list[Array]:
    """Solve sum_j A_ij y_j = x_i; a singular system gives non-finite numbers on its path only.

    The unknowns of a node are stored next to each other, so that the system is banded in nodes. It is solved by
    elimination with row exchanges. The band is narrowest if matrices with many diagonals are near each other in
    `rows`.

    Parameters
    ----------
    rows : sequence of sequences of BlockBanded or None
        A_ij, all with the same number of nodes; None for zero.
    right : sequence of ndarrays, shape (N, a_i, P)
        x_i.

    Returns
    -------
    list of ndarray, shape (N, b_j, P)
        y_j.
    """
    given = [(i, j, part) for i, row in enumerate(rows) for j, part in enumerate(row) if part is not None]
    widths = {j: part.blocks.shape[3] for _, j, part in given}
    tops = np.cumsum([0, *(x.shape[1] for x in right)])
    lefts = np.cumsum([0, *(widths[j] for j in range(len(widths)))])
    parts = [Part(int(tops[i]), int(lefts[j]), part) for i, j, part in given]
    return np.split(_solve_parts(parts, np.concatenate(right, axis=1)), lefts[1:-1], axis=1)


def _solve_parts(parts: list[Part], x: Array) -> Array:
    y, usable = _eliminate(parts, x)
    # An overflow on one path may have spread to others, so non-finite paths are solved again, each by itself.
    broken = usable & ~np.isfinite(y.sum(axis=(0, 1)))
    if broken.any():
        some = x[..., broken]
        dense = _dense([part.of(broken) for part in parts], some)
        y[..., broken] = solve(dense, some.reshape(len(dense), -1)).reshape(some.shape)
    return y


def _dense(parts: list[Part], x: Array) -> Array:
    # Return the dense matrix of each path, shape (N b, N b, P).
    N, b, P = x.shape
    # Memory order that LAPACK needs.
    dense = np.zeros((P, N, b, N, b)).transpose(1, 2, 3, 4, 0)
    for top, left, A in parts:
        height, width = A.blocks.shape[2:4]
        for k, blocks in enumerate(A.blocks):
            for i in range(N)[overlap(N, k - A.lower)[0]]:
                dense[i, top : top + height, i + k - A.lower, left : left + width] = blocks[i]
    return dense.reshape(N * b, N * b, P)


class _Layout(NamedTuple):
    # LAPACK's band storage of one path, column by column: the number of columns, the numbers of diagonals below and
    # above the main one, and for each part the indices of its entries and their targets.
    size: int
    below: int
    above: int
    sources: tuple[Array, ...]
    target: Array

    @property
    def diagonal(self) -> int:
        return self.below + self.above

    @property
    def rows(self) -> int:
        return 2 * self.below + self.above + 1


@lru_cache(maxsize=64)
def _layout(places: tuple[tuple[int, ...], ...], N: int, b: int) -> _Layout:
    sources, row, column = [], [], []
    for top, left, K, lower, height, width in places:
        k, i, a, c = (index.ravel() for index in np.indices((K, N, height, width)))
        j = i + k - lower
        inside = (j >= 0) & (j < N)
        sources.append(np.flatnonzero(inside))
        row.append((i * b + top + a)[inside])
        column.append((j * b + left + c)[inside])
    rows, columns = np.concatenate(row), np.concatenate(column)
    below, above = max(0, int((rows - columns).max())), max(0, int((columns - rows).max()))
    target = columns * (2 * below + above + 1) + rows - columns + below + above
    return _Layout(N * b, below, above, tuple(sources), target)


def _eliminate(parts: list[Part], x: Array) -> tuple[Array, Mask]:
    # Return the solution, and a mask of the paths on which all given numbers are finite.
    N, b, P = x.shape
    layout = _layout(tuple(part.place for part in parts), N, b)
    entries, right, y = _entries(layout, parts, P), x.reshape(-1, P), np.empty((P, N * b))
    usable = np.isfinite(np.add.reduce(entries) + np.add.reduce(right))
    together = max(1, LARGEST // (N * b * layout.rows))
    for paths in (slice(begin, begin + together) for begin in range(0, P, together)):
        y[paths] = _together(layout, entries[:, paths], right[:, paths].T, usable[paths])
    return np.ascontiguousarray(y.T).reshape(x.shape), usable


def _together(layout: _Layout, entries: Array, x: Array, usable: Mask) -> Array:
    # Solve one band matrix of many paths. Rows of other paths are zero in a column, so they are never its pivot; but
    # a row that is not finite would spoil neighbouring paths.
    right = x if usable.all() else np.where(usable[:, None], x, 0.0)
    # Unit rows before the first and after the last path give all paths the same neighbours: vector instructions round
    # differently at the edge of a matrix.
    ends = np.zeros(layout.below + layout.above)
    while True:
        matrix = _store_columns(layout, entries, usable, len(ends))
        flat = np.concatenate([ends, right.ravel(), ends])
        factors, _, y, info = scipy.linalg.lapack.dgbsv(
            layout.below, layout.above, matrix.T, flat, overwrite_ab=1, overwrite_b=1
        )
        if info == 0:
            break
        pivots = factors[layout.diagonal][len(ends) : len(y) - len(ends)].reshape(x.shape)
        usable = usable & (pivots != 0.0).all(axis=1)
    y = y[len(ends) : len(y) - len(ends)].reshape(x.shape)
    return y if usable.all() else np.where(usable[:, None], y, np.nan)


def _entries(layout: _Layout, parts: list[Part], P: int) -> Array:
    entries, end = np.empty((len(layout.target), P)), 0
    for source, part in zip(layout.sources, parts, strict=True):
        blocks = part.matrix.blocks
        entries[end : end + len(source)] = blocks.reshape(-1, blocks.shape[-1])[source]
        end += len(source)
    return entries


def _store_columns(layout: _Layout, entries: Array, usable: Mask, ends: int) -> Array:
    # Store the columns of all paths, with unit columns for unusable paths.
    columns = len(usable) * layout.size
    matrix = np.zeros((columns + 2 * ends, layout.rows))
    matrix[:ends, layout.diagonal] = matrix[ends + columns :, layout.diagonal] = 1.0
    paths = matrix[ends : ends + columns].reshape(len(usable), -1)
    paths[:, layout.target] = entries.T
    if not usable.all():
        paths[~usable] = 0.0
        paths[~usable, layout.diagonal :: layout.rows] = 1.0
    return matrix
