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
import scipy

from ...arrays import Array, each
from ...noise.areas import outer
from ...noise.brownian import PARTS, Increment
from ...noise.laws import GAUSSIAN, Law
from ...noise.records import NoiseRecord
from .two_rules import mixing_turn, turn

# Nodes a variable, by the number of variables; of more variables, the fewest that tell the order 2.
COUNTS = {1: 8, 2: 6, 3: 5, 4: 4}
FEWEST = 3
# A tensor rule larger than this has fewer nodes a variable, down to three, which are exact up to degree 5.
# Size: of a rule.
MOST_NODES = 2_000
# Larger than this it may not be with three nodes a variable either: so many random points take its place.
# Size: of a rule.
LARGEST, POINTS = 7_000, 2_000
# Size: any seed.
SEED = 20170601
# Nodes a variable that tell mean and covariance of a step and reach beyond two standard deviations; of more
# variables, up to how many all corners of a cube are taken; atoms and equally probable sizes at most.
FEW_NODES, SMALL, FEW_ATOMS, MOST_SIZES = {1: (6, 7), 2: (4,)}, 4, 36, 12
# Paths of a step at once: more do not stay near the processor, and a solver goes on until the last has its root.
# Size: of a batch.
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
    degree: int
        Of a rule: up to which it is exact.
    """

    x: Array
    weights: Array
    exact: bool = True
    degree: int = 5


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
    K : ndarray, shape (l, K), or None
    A : ndarray, shape (l (l - 1)/2, K), or None
        Levy areas: variables of their own, of the right mean and covariance given dW and H.
    degree : int
        Of a rule: up to which it is exact.
    """

    dW: Array
    H: Array | None
    weights: Array
    exact: bool = True
    records: Mapping[str, Any] = {}
    K: Array | None = None
    A: Array | None = None
    degree: int = 5

    def increment(self, h: float, states: int = 1) -> Increment:
        """Return the noise of a step of length h, K nodes for each of a number of states: path = state K + node."""

        def tiled(part: Array | None, scale: float) -> Array | None:
            return None if part is None else np.tile(scale * part, states)

        root = float(np.sqrt(h))
        records = each(lambda part: np.tile(part, states), self.records)
        H, K, A = tiled(self.H, root), tiled(self.K, root), tiled(self.A, h)
        return Increment(np.tile(root * self.dW, states), H, records=records, K=K, A=A)

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
        x = np.concatenate([part for part in (self.dW, self.H, self.K, self.A) if part is not None])
        if self.records or not self.exact:
            return self, np.arange(len(self.weights))
        first, place = _distinct_columns(x.tobytes(), len(x))
        return self.select(first), place

    def select(self, places: Array | slice) -> "Nodes":
        """Return some of the nodes, without records."""
        dW, H, K, A = (None if part is None else part[:, places] for part in (self.dW, self.H, self.K, self.A))
        assert dW is not None
        return Nodes(dW, H, self.weights[places], K=K, A=A, degree=self.degree)

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


def orthogonal_rule(n: int) -> Rule:
    """Return a rule for n > 2 standard normals of whatever number, in 4n + 2n nodes at most.

    The corners of `fifth_degree_rule` are those of an orthogonal array of strength 3: the rows of a Hadamard matrix
    and their negatives. It is exact up to degree 3, and for all monomials of degree 4 and 5 but products of four
    different variables. Such products in a system of many like parts might cancel at all nodes: the rule is turned
    by an orthogonal matrix, the same for each n, which leaves the degree as it is.
    """
    a, b = np.sqrt((n + 2.0) / 2.0), np.sqrt((n + 2.0) / (n - 2.0))
    signs, axes = _signs(n), np.concatenate([np.eye(n), -np.eye(n)], axis=1)
    count = signs.shape[1]
    weights = np.concatenate([np.full(count, 1.0 / count / b**4), np.full(2 * n, a**-4)])
    return Rule(turn(n, SEED + 6) @ np.concatenate([b * signs, a * axes], axis=1), weights, degree=3)


def _signs(n: int) -> Array:
    """Return an orthogonal array of strength 3: the rows of a Hadamard matrix of n variables and their negatives."""
    half = scipy.linalg.hadamard(1 << (n - 1).bit_length())[:, :n].T
    return np.concatenate([half, -half], axis=1)


def resolving_rule(dimension: int, count: int) -> Rule:
    """Return `normal_rule` where that is exact, and of more variables one that still resolves means.

    Parameters
    ----------
    dimension : int
        Number of standard normals.
    count : int
        Nodes a variable at most.
    """
    rule = normal_rule(dimension, count)
    return rule if rule.exact else orthogonal_rule(dimension)


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


def other_rule(dimension: int, count: int) -> Rule:
    """Return a rule that is exact to no lower degree than `normal_rule` and shares no node with it but 0.

    The means of a polynomial are the same by both. Those of a function that jumps or bends differ.

    Parameters
    ----------
    dimension : int
        Number of variables.
    count : int
        Nodes of `normal_rule` a variable at most: one less than those of a single variable here.
    """
    if dimension == 1:
        return normal_rule(1, count + 1)
    rule = normal_rule(dimension, count)
    return rule._replace(x=mixing_turn(dimension) @ rule.x)


def step_nodes(dimension: int, count: int, *, areas: bool = False, law: Law = GAUSSIAN, other: bool = False) -> Nodes:
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
    other : bool
        Whether they are those of `other_rule`; the atoms of a bounded law are the same.

    Returns
    -------
    Nodes
    """
    if law.bounded:
        rule = atom_rule(law.atoms(dimension, areas=areas))
    else:
        rule = (other_rule if other else normal_rule)(dimension * (2 if areas else 1), count)
    H = rule.x[dimension:] / np.sqrt(12.0) if areas else None
    return Nodes(rule.x[:dimension], H, rule.weights, rule.exact)


def law_nodes(dimension: int, noise: frozenset[str], law: Law = GAUSSIAN) -> tuple[Nodes, Nodes]:
    """Return two sets of nodes for the noise of one step that are exact up to degree 3, whatever noise that is.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    noise : frozenset of str
        What a scheme uses of dW, H, K and A.
    law : Law
        Of dW, and of H where it is bounded.

    Returns
    -------
    Nodes, Nodes
        Few of them, which resolve mean and covariance of a step. Both are the same of a bounded law; else they have
        no variable's values in common.
    """
    l = dimension
    sizes = {"dW": l} | {name: l for name in ("H", "K") if name in noise}
    if "A" in noise and l > 1:
        sizes["A"] = l * (l - 1) // 2
    if law.bounded:
        signed = _named_nodes(_signed_rule(l + sizes.get("H", 0), l, law), sizes)
        return signed, signed
    first, second = (_named_nodes(rule, sizes) for rule in _two_rules(sum(sizes.values())))
    return first, second


def _named_nodes(rule: Rule, sizes: dict[str, int]) -> Nodes:
    """Return the variables of a rule as the noise of a step of length 1, so many of each kind."""
    parts = dict(zip(sizes, np.split(rule.x, np.cumsum(list(sizes.values()))[:-1]), strict=True))
    H, K = (parts[name] / np.sqrt(PARTS[name]) if name in parts else None for name in ("H", "K"))
    A = areas_at(parts["dW"], H, parts["A"], 1.0) if "A" in parts else None
    return Nodes(parts["dW"], H, rule.weights, rule.exact, K=K, A=A)


def _two_rules(n: int) -> tuple[Rule, Rule]:
    if n == 1:
        few, more = (tensor_rule([gauss_hermite(count)]) for count in FEW_NODES[n])
        return few, more
    if n in FEW_NODES:
        rule = tensor_rule([gauss_hermite(FEW_NODES[n][0])] * n)
    else:
        rule = fifth_degree_rule(n) if n <= SMALL else orthogonal_rule(n)
    return rule, rule._replace(x=mixing_turn(n) @ rule.x)


def areas_at(dW: Array, H: Array | None, x: Array, h: float) -> Array:
    """Return areas of a step of length h from standard variables x that are independent of all else.

    Given dW alone they have mean 0 and the variance h^2/4; given H, too, the mean H_i dW_j - H_j dW_i, around which
    h^2/12 is left.

    Parameters
    ----------
    dW : ndarray, shape (l, K)
        Increments.
    H : ndarray, shape (l, K), or None
        Their time integrals, where they are known.
    x : ndarray, shape (l (l - 1)/2, K)
        Standard variables.
    h : float
        Length of the step.
    """
    return np.asarray(0.5 * h * x if H is None else outer(H, dW) + h / np.sqrt(12.0) * x)


def _signed_rule(n: int, l: int, law: Law) -> Rule:
    """Return atoms of l variables of a law and n - l signs, exact up to degree 3: all, or signs crossed with sizes.

    Of sizes, one after the other of equally probable ones are taken, a place further in each variable.
    """
    axes = law.atoms(l, areas=n > l)
    if count_atoms(axes) <= FEW_ATOMS:
        return tensor_rule(axes)
    signs, sizes = _signs(n), _equal_sizes(law)
    if sizes is None:
        return atom_rule(axes)
    shifts = (np.arange(len(sizes)) + np.arange(l)[:, None]) % len(sizes)
    x = np.repeat(signs, len(sizes), axis=1).astype(float)
    x[:l] *= np.tile(sizes[shifts], signs.shape[1])
    return Rule(x, np.full(x.shape[1], 1.0 / x.shape[1]))


def _equal_sizes(law: Law) -> Array | None:
    """Return equally probable sizes that a symmetric law takes with a sign of its own; None for another law."""
    sizes, weights = np.abs(law.values), np.array(law.weights)
    if not np.allclose(weights @ (np.sign(law.values)), 0.0):
        return None
    for count in range(1, MOST_SIZES + 1):
        times = np.array([count * weights[sizes == size].sum() for size in np.unique(sizes)])
        if np.allclose(times, np.round(times)):
            return np.repeat(np.unique(sizes), np.round(times).astype(int))
    return None


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
    H, K, A = (each(spread, part) for part in (nodes.H, nodes.K, nodes.A))
    return Nodes(spread(nodes.dW), H, joint, nodes.exact, records, K, A, nodes.degree)


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
    dimension: int,
    count: int,
    *,
    areas: bool = False,
    levy: bool = False,
    rule: Callable[[int, int], Rule] = resolving_rule,
) -> HalfSteps:
    """Return nodes for the Gaussian noise of two half steps and of the step they make up.

    dW = dW_1 + dW_2,   H = (H_1 + H_2)/2 + (dW_1 - dW_2)/4,   A = A_1 + A_2 + (dW_1 x dW_2 - dW_2 x dW_1)/2.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    count : int
        Nodes of each normal.
    areas : bool
        Whether time integrals H go with dW.
    levy : bool
        Whether Levy areas A between the motions do.
    rule : callable, optional
        `resolving_rule`, or `product_rule` for means over some of the normals given the others.
    """
    own = dimension * (4 if areas else 2)
    between = dimension * (dimension - 1) // 2 if levy else 0
    x, weights, exact, degree = rule(own + 2 * between, count)
    (W1, W2), (H1, H2), A1, A2 = *_of_halves(x[:own], areas=areas), *np.split(x[own:], 2)
    H = None if H1 is None or H2 is None else 0.5 * (H1 + H2) + 0.25 * (W1 - W2)
    if not between:
        pairs = (W1 + W2, H), (W1, H1), (W2, H2)
        return HalfSteps(*(Nodes(W, h, weights, exact, degree=degree) for W, h in pairs))
    first, second = areas_at(W1, H1, A1, 0.5), areas_at(W2, H2, A2, 0.5)
    steps = (W1 + W2, H, first + second + 0.5 * outer(W1, W2)), (W1, H1, first), (W2, H2, second)
    return HalfSteps(*(Nodes(W, h, weights, exact, A=A, degree=degree) for W, h, A in steps))


def _of_halves(x: Array, *, areas: bool) -> tuple[tuple[Array, Array], tuple[Array | None, Array | None]]:
    """Return dW and H of two half steps from standard normals."""
    W1, W2, *rest = np.split(x / np.sqrt(2.0), 4 if areas else 2)
    H1, H2 = (part / np.sqrt(12.0) for part in rest) if areas else (None, None)
    return (W1, W2), (H1, H2)
