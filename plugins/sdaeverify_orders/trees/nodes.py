"""Noise of one step of length 1: random points for conditions on paths, and rules for expectations.

A polynomial can vanish at all nodes of a rule, as dW^3 - 3 h dW does at three nodes. Therefore paths are compared at
random points. The rules are exact for forests up to the weight 5, for any combination of dW, H, K and A.
"""

from itertools import combinations, product
from math import sqrt

import numpy as np
import scipy

from sdaeverify import Array, Law
from sdaeverify.probing import Nodes, step_nodes

SEED = 20260101
# Number of random points, and nodes per variable of a rule; fewer for rules with many variables.
POINTS, COUNT, FEWEST = 12, 5, 3
# Extent of a line through the noise to either side, in standard deviations.
REACH = 2.0
# Number of variables up to which all signs are used; for up to eight, an orthogonal array of strength 3.
FEW_SIGNS = 3


def random_points(motions: int, law: Law, count: int = POINTS) -> Nodes:
    """Return random noise with dW, H, K and A: atoms of a bounded law, or independent normal variables.

    Parameters
    ----------
    motions : int
    law : Law
    count : int
        Number of points.
    """
    rng = np.random.Generator(np.random.Philox(key=SEED))
    H, K, A = (rng.standard_normal((rows, count)) for rows in (motions, motions, motions * (motions - 1) // 2))
    dW = rng.standard_normal((motions, count))
    weights = np.full(count, 1.0 / count)
    if law.bounded:
        dW, H = law.couple(dW), np.sign(H)
    return Nodes(dW, H / sqrt(12.0), weights, exact=False, K=K / sqrt(720.0), A=A / 2.0)


def line_points(motions: int, noise: frozenset[str], count: int) -> Nodes:
    """Return noise of a step of length 1 on a straight line that avoids 0, at roots of a Chebyshev polynomial.

    Each variable, and most products of two, change sign along the line, and each exceeds one standard deviation.

    Parameters
    ----------
    motions : int
    noise : frozenset of str
        Which of dW, H, K and A are used.
    count : int
        Number of points.
    """
    rng = np.random.Generator(np.random.Philox(key=SEED + 1))
    s = np.cos(np.pi * (np.arange(count) + 0.5) / count)

    def line(rows: int, scale: float) -> Array:
        slopes = rng.uniform(0.75, 1.0, (rows, 1)) * rng.choice([-1.0, 1.0], (rows, 1))
        return np.asarray(scale * (REACH * slopes * s + rng.uniform(-0.5, 0.5, (rows, 1))))

    dW, H, K = (line(motions, sqrt(1.0 / part)) for part in (1, 12, 720))
    A = line(motions * (motions - 1) // 2, 0.5)
    parts = {name: part for name, part in (("H", H), ("K", K), ("A", A)) if name in noise}
    return Nodes(dW, parts.get("H"), np.full(count, 1.0 / count), exact=False, K=parts.get("K"), A=parts.get("A"))


def rule_nodes(motions: int, noise: frozenset[str], law: Law, count: int = COUNT, *, other: bool = False) -> Nodes:
    """Return a quadrature rule for the noise of a step of length 1.

    K is an independent normal variable. The part of A that is independent of dW, H and K is replaced by signs with
    the same relevant moments, since products of three areas already have the weight 6.

    Parameters
    ----------
    motions : int
    noise : frozenset of str
        Which of dW, H, K and A are used.
    law : Law
        Law of dW, and of H if it is bounded.
    count : int
        Largest number of nodes per variable.
    other : bool
        Whether dW, H and K have other nodes, which also give the means of polynomials exactly.
    """
    nodes = step_nodes(motions, count, areas="H" in noise, law=law, other=other)
    if "K" in noise:
        K, weights = (part := step_nodes(motions, FEWEST, other=other)).dW, part.weights
        nodes = _crossed(nodes, weights)._replace(K=np.tile(K / sqrt(720.0), len(nodes.weights)))
    if "A" in noise and motions > 1:
        signs = _signs(motions * (motions - 1) // 2)
        crossed = _crossed(nodes, np.full(signs.shape[1], 1.0 / signs.shape[1]))
        nodes = crossed._replace(A=_areas(crossed, np.tile(signs, len(nodes.weights))))
    return nodes


def _crossed(nodes: Nodes, weights: Array) -> Nodes:
    """Return the product of the nodes with an independent variable with given weights."""

    def spread(part: Array | None) -> Array | None:
        return None if part is None else np.repeat(part, len(weights), axis=1)

    dW = np.repeat(nodes.dW, len(weights), axis=1)
    return Nodes(dW, spread(nodes.H), np.outer(nodes.weights, weights).ravel(), nodes.exact, K=spread(nodes.K))


def _signs(n: int) -> Array:
    if n <= FEW_SIGNS:
        return np.array([*product((-1.0, 1.0), repeat=n)]).T
    size = 2 ** int(np.ceil(np.log2(n)))
    some = scipy.linalg.hadamard(size, dtype=float)[:, :n]
    return np.concatenate([some, -some]).T


def _areas(nodes: Nodes, signs: Array) -> Array:
    dW, H, K = nodes.dW, nodes.H, nodes.K
    pairs = [*combinations(range(len(dW)), 2)]
    if H is None:
        return 0.5 * signs
    known = np.array([H[i] * dW[j] - H[j] * dW[i] for i, j in pairs])
    if K is None:
        return known + signs / sqrt(12.0)
    return known + 12.0 * np.array([K[i] * H[j] - K[j] * H[i] for i, j in pairs]) + signs / sqrt(20.0)
