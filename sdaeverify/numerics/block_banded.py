"""Block-banded matrices on every path at once: what couples nodes in a row with their neighbours only."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True, eq=False)
class BlockBanded:
    """A matrix A of N x N blocks of shape (a, b), of which only those near the diagonal are not zero.

    Attributes
    ----------
    blocks : ndarray, shape (K, N, a, b, P) or (K, N, a, b, 1)
        ``blocks[k, i]`` is A_{i,j} with j = i + k - lower; zero where there is no node j.
    lower : int
        Number of block diagonals below the main one; K - 1 - lower are above it.
    """

    blocks: Array
    lower: int = 0

    # Numbers times a matrix come here, too.
    __array_ufunc__ = None

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
        return self + (-1.0) * other

    def __rmul__(self, factor: float) -> "BlockBanded":
        return BlockBanded(factor * self.blocks, self.lower)

    def __matmul__(self, other: "BlockBanded") -> "BlockBanded":
        """Return the product; its bands are as wide as both together."""
        A, B = self.blocks, other.blocks
        if len(A) == len(B) == 1:
            return BlockBanded(np.einsum("knabp,knbcp->knacp", A, B))
        N, paths = A.shape[1], max(A.shape[-1], B.shape[-1])
        product = np.zeros((len(A) + len(B) - 1, N, A.shape[2], B.shape[3], paths))
        for k in range(len(A)):
            rows, columns = overlap(N, k - self.lower)
            for j in range(len(B)):
                product[k + j, rows] += np.einsum("nabp,nbcp->nacp", A[k, rows], B[j, columns])
        return BlockBanded(product, self.lower + other.lower)

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
        """Return the norm for largest components: the largest sum of absolute values over a row, (P,) or (1,)."""
        rows: Array = np.abs(self.blocks).sum(axis=(0, 3)).max(axis=(0, 1))
        return rows


def identity(nodes: int, size: int) -> BlockBanded:
    """Return the identity with blocks of shape (size, size), one for all paths."""
    return BlockBanded(np.broadcast_to(np.eye(size)[..., None], (1, nodes, size, size, 1)))


def overlap(nodes: int, offset: int) -> tuple[slice, slice]:
    """Return the rows i of blocks that have a node i + offset, and these nodes."""
    rows, columns = (slice(max(0, -o), max(0, min(nodes, nodes - o))) for o in (offset, -offset))
    return rows, columns
