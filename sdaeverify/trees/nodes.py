"""Noise of one step of length 1: random points where paths are compared, and rules for expectations.

A polynomial can vanish at all nodes of a rule, as dW^3 - 3 h dW does at three: paths are compared at random points.
The rules are exact for forests up to the weight 5, whatever of dW, H, K and A a step uses.
"""

from itertools import combinations, product
from math import sqrt

import numpy as np
import scipy

from ..arrays import Array
from ..noise.laws import Law
from ..probing import Nodes, step_nodes

SEED = 20260101
# Points where paths are compared, and nodes a variable of a rule; fewer where rules are long.
POINTS, COUNT, FEWEST = 12, 5, 3
# Standard deviations that a line through the noise goes to either side.
REACH = 2.0
# A rule of signs of more variables than three is one of strength 3 for up to eight of them.
FEW_SIGNS = 3


def random_points(motions: int, law: Law) -> Nodes:
    """Return random noise with dW, H, K and A: of a bounded law some atoms, else independent normals.

    Parameters
    ----------
    motions : int
    law : Law
    """
    rng = np.random.Generator(np.random.Philox(key=SEED))
    H, K, A = (rng.standard_normal((rows, POINTS)) for rows in (motions, motions, motions * (motions - 1) // 2))
    dW = rng.standard_normal((motions, POINTS))
    weights = np.full(POINTS, 1.0 / POINTS)
    if law.bounded:
        dW, H = law.couple(dW), np.sign(H)
    return Nodes(dW, H / sqrt(12.0), weights, exact=False, K=K / sqrt(720.0), A=A / 2.0)


def line_points(motions: int, noise: frozenset[str], count: int) -> Nodes:
    """Return noise of a step of length 1 on a straight line that does not meet 0, at roots of a Chebyshev polynomial.

    Each variable, and most products of two, change their sign along it, and each goes beyond a standard deviation.

    Parameters
    ----------
    motions : int
    noise : frozenset of str
        What of dW, H, K and A is used.
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
    """Return a rule for the noise of a step of length 1.

    K is a normal variable of its own, and so is what dW, H and K leave of A, of which signs have the moments that
    count: products of three areas have the weight 6.

    Parameters
    ----------
    motions : int
    noise : frozenset of str
        What of dW, H, K and A is used.
    law : Law
        Of dW, and of H where it is bounded.
    count : int
        Nodes a variable at most.
    other : bool
        Whether dW, H and K are at other nodes, which give the means of polynomials as well.
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
    """Return each node once for each of some weights of an independent variable."""

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
