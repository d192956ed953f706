"""Random block-banded matrices, and the same written out."""

import numpy as np

from sdaeverify.numerics import BlockBanded


def banded(shape, lower, upper, paths=4, seed=0):
    """Return a random matrix with blocks of a shape (N, a, b)."""
    N = shape[0]
    blocks = np.random.default_rng(seed).standard_normal((lower + upper + 1, *shape, paths))
    for k in range(lower + upper + 1):
        for i in range(N):
            if not 0 <= i + k - lower < N:
                blocks[k, i] = 0.0
    return BlockBanded(blocks, lower)


def dense(A):
    """Write out a matrix, shape (N a, N b, P)."""
    K, N, a, b, paths = A.blocks.shape
    full = np.zeros((N, a, N, b, paths))
    for k in range(K):
        for i in range(N):
            if 0 <= i + k - A.lower < N:
                full[i, :, i + k - A.lower] = A.blocks[k, i]
    return full.reshape(N * a, N * b, paths)
