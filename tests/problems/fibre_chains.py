"""Chains for tests of fibres, and the constraint written out point by point from Lindner et al. (2018), (2.7)."""

import numpy as np

from facade import Chain, clamped_chain, free_chain
from sdaeverify import Array

CHAINS = {
    f"{make.__name__} N={N} d={d}": make(N, d)
    for make in (clamped_chain, free_chain)
    for N, d in ((2, 2), (3, 3), (7, 2), (5, 3))
}


def curved(chain: Chain, paths: int, seed: int = 0) -> Array:
    """Return consistent positions of chains that bend everywhere, shape (n, P)."""
    rng = np.random.default_rng(seed)
    steps = rng.standard_normal((chain.N, chain.d, paths))
    steps *= chain.ds / np.linalg.norm(steps, axis=1, keepdims=True)
    start = rng.standard_normal((chain.d, paths)) if chain.root is None else chain.root[1]
    return (start + np.cumsum(steps, axis=0)).reshape(-1, paths)


def defects(chain: Chain, r: Array) -> Array:
    """Return g with a loop over the points."""
    points = list(r.reshape(chain.N, chain.d, -1))
    if chain.root is not None:
        points = [chain.root[1] * np.ones_like(points[0]), *points]
    pairs = zip(points[1:], points[:-1], strict=True)
    return np.stack([0.5 * (1.0 - ((a - b) ** 2).sum(axis=0) / chain.ds**2) for a, b in pairs])


def derivative(f, x: Array) -> Array:
    """Return Df(x), shape (m, n, P), by a complex step for each column."""
    columns = []
    for k in range(len(x)):
        z = x.astype(complex)
        z[k] += 1e-30j
        columns.append(f(z).imag / 1e-30)
    return np.stack(columns, axis=1)
