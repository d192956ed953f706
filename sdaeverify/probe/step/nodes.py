"""Cubature nodes for the noise of one step, in units in which the step has length 1.

An expectation over the noise is a weighted sum over nodes: exact for the atoms of a bounded variable, and for
polynomials up to degree 2n - 1 in each normal with n Gauss-Hermite nodes. A step's terms of order h^{k/2} are
polynomials of degree k, so that degree 5 in all normals together tells its means up to the order 2.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import pairwise
from math import prod
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, each
from ...noise.brownian import Increment
from ...noise.laws import GAUSSIAN, Law
from ...noise.records import NoiseRecord

# Nodes a variable, by the number of variables; of more variables, the fewest that tell the order 2.
COUNTS = {1: 8, 2: 6, 3: 5, 4: 4}
FEWEST = 3
# A tensor rule larger than this has fewer nodes a variable, down to three, which are exact up to degree 5.
MOST_NODES = 2_000
# Larger than this it may not be with three nodes a variable either: so many random points take its place.
LARGEST, POINTS = 7_000, 2_000
SEED = 20170601
# Paths of a step at once: more do not stay near the processor, and a solver goes on until the last has its root.
BATCH = 16_384


class Rule(NamedTuple):
    """A cubature rule for independent variables of mean 0 and variance 1.

    Attributes
    ----------
    x : ndarray, shape (n, K)
    weights : ndarray, shape (K,)
        Positive, of sum 1.
    exact : bool
        False for random points: root mean squares are known to about 5 per cent, their ratios between step sizes
        much better, means not at all.
    """

    x: Array
    weights: Array
    exact: bool = True


class Nodes(NamedTuple):
    """Noise of a step of length 1 at the nodes of a rule.

    Attributes
    ----------
    dW : ndarray, shape (l, K)
    H : ndarray, shape (l, K), or None
    weights : ndarray, shape (K,)
    exact : bool
        Whether it is a rule and not random points.
    records : mapping of str to object
        Noise beside Brownian motions, of a step of one length alone.
    """

    dW: Array
    H: Array | None
    weights: Array
    exact: bool = True
    records: Mapping[str, Any] = {}

    def increment(self, h: float, states: int = 1) -> Increment:
        """Return the noise of a step of length h, K nodes for each of a number of states: path = state K + node."""
        dW = np.tile(np.sqrt(h) * self.dW, states)
        records = each(lambda part: np.tile(part, states), self.records)
        return Increment(dW, None if self.H is None else np.tile(np.sqrt(h) * self.H, states), records=records)

    def few(self, count: int) -> "Nodes":
        """Return a rule as it is, and so many of random points at most."""
        if self.exact or count >= len(self.weights):
            return self
        H = None if self.H is None else self.H[:, :count]
        return Nodes(self.dW[:, :count], H, np.full(count, 1.0 / count), exact=False)

    def in_batches(self, states: int) -> "list[Nodes]":
        """Return the nodes in parts that so many states at each make no long batch of; with records, as one."""
        count = len(self.weights)
        parts = -(-states * count // BATCH)
        if parts <= 1 or self.records:
            return [self]
        ends = np.linspace(0, count, parts + 1).astype(int).tolist()
        return [self.select(slice(*pair)) for pair in pairwise(ends)]

    def find_distinct(self) -> "tuple[Nodes, Array]":
        """Return the nodes whose noise is no other one's, and the place of each node among them.

        What is asked at these alone holds at all: half the noise of a product rule has few values, each of them many
        times. Nodes with records are taken as they are.
        """
        x = self.dW if self.H is None else np.concatenate([self.dW, self.H])
        if self.records or not self.exact:
            return self, np.arange(len(self.weights))
        first, place = _distinct_columns(x.tobytes(), len(x))
        return self.select(first), place

    def select(self, places: Array | slice) -> "Nodes":
        """Return some of the nodes, without records."""
        return Nodes(self.dW[:, places], None if self.H is None else self.H[:, places], self.weights[places])

    def mean(self, values: Array) -> Array:
        """Return the expectation over the nodes of values of shape (..., K)."""
        return np.asarray(np.einsum("...k,k->...", values, self.weights))


@lru_cache(maxsize=8)
def _distinct_columns(x: bytes, rows: int) -> tuple[Array, Array]:
    # Where each column is found first, and which of these every column is.
    _, first, place = np.unique(np.frombuffer(x).reshape(rows, -1), axis=1, return_index=True, return_inverse=True)
    return first, place.ravel()


@lru_cache(maxsize=64)
def gauss_hermite(count: int) -> tuple[Array, Array]:
    """Return the Gauss-Hermite nodes and weights of the standard normal law, each of shape (count,)."""
    x, w = np.polynomial.hermite_e.hermegauss(count)
    w /= w.sum()
    for part in (x, w):
        part.flags.writeable = False
    return x, w


def tensor_rule(axes: list[tuple[Array, Array]]) -> Rule:
    """Return the product of one-dimensional rules, given as (nodes, weights)."""
    x = np.meshgrid(*(nodes for nodes, _ in axes), indexing="ij")
    weights = np.ones(1)
    for _, w in axes:
        weights = np.multiply.outer(weights, w).ravel()
    return Rule(np.stack([part.ravel() for part in x]), weights)


def normal_rule(dimension: int, count: int) -> Rule:
    """Return a rule for independent standard normals.

    Parameters
    ----------
    dimension : int
        Number of variables.
    count : int
        Nodes a variable at most.

    Returns
    -------
    Rule
        Of more variables than four, one of the fifth degree, or random points where these are too many.
    """
    if dimension > len(COUNTS) and count >= FEWEST and FEWEST**dimension <= LARGEST:
        return fifth_degree_rule(dimension)
    return product_rule(dimension, count)


def product_rule(dimension: int, count: int) -> Rule:
    """Return the same as a product of rules of one variable: random points where three nodes each are too many."""
    for fewer in range(count, min(count, FEWEST) - 1, -1):
        if fewer**dimension <= (MOST_NODES if fewer > FEWEST else LARGEST):
            return tensor_rule([gauss_hermite(fewer)] * dimension)
    points = np.random.Generator(np.random.Philox(key=SEED)).standard_normal((dimension, POINTS))
    return Rule(points, np.full(POINTS, 1.0 / POINTS), exact=False)


def fifth_degree_rule(n: int) -> Rule:
    """Return a rule for n > 2 standard normals that is exact for polynomials of degree 5, in 2^n + 2n nodes.

    With a^2 = (n + 2)/2 and b^2 = (n + 2)/(n - 2), the points +-a e_i on the axes and the corners b (+-1, ..., +-1)
    of a cube, of weights 1/a^4 and 2^{-n}/b^4 (Stroud 1971, E_n^{r^2} 5-3). Three nodes a variable are exact to the
    same degree, in 3^n nodes. Some polynomials of degree 3 vanish at all nodes, as x_i (x_j^2 - x_k^2) does, but
    not what an error of degree 3 in the noise of a step adds to the defect of one step against two halves.
    """
    a, b = np.sqrt((n + 2.0) / 2.0), np.sqrt((n + 2.0) / (n - 2.0))
    corners = tensor_rule([(np.array([-b, b]), np.full(2, 0.5))] * n)
    axes = np.concatenate([a * np.eye(n), -a * np.eye(n)], axis=1)
    weights = np.concatenate([corners.weights / b**4, np.full(2 * n, a**-4)])
    return Rule(np.concatenate([corners.x, axes], axis=1), weights)


def atom_rule(axes: list[tuple[Array, Array]]) -> Rule:
    """Return all atoms of independent variables, given as (values, weights), or random ones of too many."""
    if count_atoms(axes) <= LARGEST:
        return tensor_rule(axes)
    rng = np.random.Generator(np.random.Philox(key=SEED))
    points = np.stack([rng.choice(values, size=POINTS, p=weights) for values, weights in axes])
    return Rule(points, np.full(POINTS, 1.0 / POINTS), exact=False)


def count_atoms(axes: list[tuple[Array, Array]]) -> int:
    """Return the number of atoms of independent variables."""
    return prod(len(values) for values, _ in axes)


def step_nodes(dimension: int, count: int, *, areas: bool = False, law: Law = GAUSSIAN) -> Nodes:
    """Return nodes for the noise of one step.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    count : int
        Gauss-Hermite nodes a variable at most; a bounded law has its atoms instead.
    areas : bool
        Whether H varies beside dW.
    law : Law
        Of dW, and of H where it is bounded.

    Returns
    -------
    Nodes
    """
    if law.bounded:
        rule = atom_rule(law.atoms(dimension, areas=areas))
    else:
        rule = normal_rule(dimension * (2 if areas else 1), count)
    H = rule.x[dimension:] / np.sqrt(12.0) if areas else None
    return Nodes(rule.x[:dimension], H, rule.weights, rule.exact)


def cross_with(nodes: Nodes, name: str, data: Any, weights: Array) -> Nodes:
    """Return each node with each of R nodes of an independent record, whose probabilities are `weights`.

    Parameters
    ----------
    nodes : Nodes
    name : str
        What the record is called in an increment.
    data : ndarray or record of ndarray, shape (..., R)
        The record at its nodes.
    weights : ndarray, shape (R,)
        Probabilities of its nodes.
    """

    def spread(part: Array) -> Array:
        return np.repeat(part, len(weights), axis=-1)

    records = {**each(spread, nodes.records), name: each(lambda part: np.tile(part, len(nodes.weights)), data)}
    joint = np.multiply.outer(nodes.weights, weights).ravel()
    return Nodes(spread(nodes.dW), each(spread, nodes.H), joint, nodes.exact, records)


class HalfSteps(NamedTuple):
    """Noise of a step of length 1 and of its two halves, at common nodes.

    Attributes
    ----------
    whole, first, second : Nodes
        The halves in the units of the whole step.
    """

    whole: Nodes
    first: Nodes
    second: Nodes

    def with_records(self, records: tuple[NoiseRecord, ...], h: float) -> "HalfSteps":
        """Return the same with the noise beside Brownian motions of a step of size h."""
        found = self
        for record in records:
            (first, second), weights = _pairs(*record.rule(0.5 * h))
            steps = (record.joined(first, second), first, second)
            found = HalfSteps(*(cross_with(n, record.name, d, weights) for n, d in zip(found, steps, strict=True)))
        return found


def _pairs(data: Any, weights: Array) -> tuple[tuple[Any, Any], Array]:
    count = len(weights)
    pair = each(lambda part: np.repeat(part, count, axis=-1), data), each(lambda part: np.tile(part, count), data)
    return pair, np.multiply.outer(weights, weights).ravel()


def half_steps(
    dimension: int, count: int, *, areas: bool = False, rule: Callable[[int, int], Rule] = normal_rule
) -> HalfSteps:
    """Return nodes for the Gaussian noise of two half steps and of the step they make up.

    dW = dW_1 + dW_2,   H = (H_1 + H_2)/2 + (dW_1 - dW_2)/4.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    count : int
        Nodes of each normal.
    areas : bool
        Whether time integrals H go with dW.
    rule : callable, optional
        `normal_rule`, or `product_rule` for means over some of the normals given the others.
    """
    x, weights, exact = rule(dimension * (4 if areas else 2), count)
    W1, W2, *areas_ = np.split(x / np.sqrt(2.0), 4 if areas else 2)
    if not areas:
        return HalfSteps(*(Nodes(W, None, weights, exact) for W in (W1 + W2, W1, W2)))
    H1, H2 = (part / np.sqrt(12.0) for part in areas_)
    H = 0.5 * (H1 + H2) + 0.25 * (W1 - W2)
    pairs = ((W1 + W2, H), (W1, H1), (W2, H2))
    return HalfSteps(*(Nodes(W, A, weights, exact) for W, A in pairs))
