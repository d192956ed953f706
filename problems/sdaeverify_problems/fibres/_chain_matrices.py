"""Differences and means along a chain as matrices, which act on one component of all points."""

import numpy as np

from sdaeverify import Array

from ._chain import Chain


def scalar_matrices(chain: Chain) -> tuple[Array, Array]:
    """Return the matrices that act on one component of directions: fourth differences and edge means.

    Returns
    -------
    S : ndarray, shape (N, N)
    W : ndarray, shape (N + 1, N)
        Maps points to all edges, including those beyond a free end.
    """
    scalar = chain._replace(d=1, root=None if chain.root is None else np.zeros((2, 1, 1)))
    x = scalar.positions(np.eye(chain.N))
    return np.diff(scalar.bends(x), 2, axis=0)[:, 0], 0.5 * (x[1:, 0] + x[:-1, 0])
