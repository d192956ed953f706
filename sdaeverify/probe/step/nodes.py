"""Cubature nodes for the noise of one step, scaled to a step of length 1.

An expectation over the noise is a weighted sum over nodes. It is exact for the atoms of a discrete variable, and for
polynomials up to degree 2n - 1 in each normal with n Gauss-Hermite nodes. Terms of order h^{k/2} in a step are
polynomials of degree k, so that degree 5 in all normals together gives the means of a step up to order 2.
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
from .two_rules import AGREEMENT, SCATTERED, SHAPED, mixing_turn, scattered, turn

# Nodes per variable, by the number of variables; for more variables, the fewest that resolve order 2.
COUNTS = {1: 8, 2: 6, 3: 5, 4: 4}
# Size: nodes of a variable.
FEWEST = 3
# A larger tensor rule has fewer nodes per variable, down to three, which are exact up to degree 5.
# Size: of a rule.
MOST_NODES = 2_000
# If even the rule with three nodes per variable exceeds the first, this number of random points replaces it.
# Size: of a rule.
LARGEST, POINTS = 7_000, 2_000
# Size: any seed.
SEED = 20170601
# Nodes per variable that give mean and covariance of a step and reach beyond two standard deviations; the largest
# number of variables for which all corners of a cube are used; the most atoms and the most equally probable sizes.
FEW_NODES, SMALL, FEW_ATOMS, MOST_SIZES = {1: (6, 7), 2: (4,)}, 4, 36, 12
# Most paths of one call: more do not fit the processor's caches, and a solver iterates until the last path has its
# root.
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
        False for random points: root mean squares are then known to about 5 per cent, their ratios between step sizes
        much better, means not at all.
    degree : int
        Degree up to which the rule is exact for polynomials.
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
        Whether the nodes are those of a rule and not random points.
    records : mapping of str to object
        Noise other than Brownian motions, for a step of a fixed length.
    K : ndarray, shape (l, K), or None
    A : ndarray, shape (l (l - 1)/2, K), or None
        Levy areas, from independent variables, with the right mean and covariance given dW and H.
    degree : int
        Degree up to which a rule is exact for polynomials.
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
        """Return the noise of a step of length h, with K nodes for each of `states` states: path = state K + node."""

        def tiled(part: Array | None, scale: float) -> Array | None:
            return None if part is None else np.tile(scale * part, states)

        root = float(np.sqrt(h))
        records = each(lambda part: np.tile(part, states), self.records)
        H, K, A = tiled(self.H, root), tiled(self.K, root), tiled(self.A, h)
        return Increment(np.tile(root * self.dW, states), H, records=records, K=K, A=A)

    @staticmethod
    def why_inexact(means: tuple[float, float], defect: float) -> str:
        """Return that two rules disagree on a mean by too much for its defect to be known, or an empty text."""
        return SHAPED if abs(means[0] - means[1]) > AGREEMENT * defect else ""

    def in_batches(self, states: int) -> "list[Nodes]":
        """Split the nodes so that calls on `states` states have at most `BATCH` paths; not split with records."""
        count = len(self.weights)
        parts = -(-states * count // BATCH)
        if parts <= 1 or self.records:
            return [self]
        ends = np.linspace(0, count, parts + 1).astype(int).tolist()
        return [self.select(slice(*pair)) for pair in pairwise(ends)]

    def find_distinct(self) -> "tuple[Nodes, Array]":
        """Return the nodes with distinct noise, and the index among them for each node.

        A function of the noise needs to be evaluated at these only: half the noise of a product rule has few values,
        each repeated many times. Nodes with records, or random points, are returned unchanged.
        """
        x = np.concatenate([part for part in (self.dW, self.H, self.K, self.A) if part is not None])
        if self.records or not self.exact:
            return self, np.arange(len(self.weights))
        first, place = _distinct_columns(x.tobytes(), len(x))
        return self.select(first), place

    def select(self, places: Array | slice) -> "Nodes":
        """Return the nodes at some indices, without records."""
        dW, H, K, A = (None if part is None else part[:, places] for part in (self.dW, self.H, self.K, self.A))
        assert dW is not None
        return Nodes(dW, H, self.weights[places], K=K, A=A, degree=self.degree)

    def mean(self, values: Array) -> Array:
        """Return the expectation of values of shape (..., K) over the nodes."""
        return np.asarray(np.einsum("...k,k->...", values, self.weights))


@lru_cache(maxsize=8)
def _distinct_columns(x: bytes, rows: int) -> tuple[Array, Array]:
    # Return the index of the first occurrence of each distinct column, and for every column the index of its value.
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
        Largest number of nodes per variable.

    Returns
    -------
    Rule
        For more than four variables a rule of degree 5, or random points if it would have too many nodes.
    """
    if dimension > len(COUNTS) and count >= FEWEST and FEWEST**dimension <= LARGEST:
        return fifth_degree_rule(dimension)
    return product_rule(dimension, count)


def product_rule(dimension: int, count: int) -> Rule:
    """Return a product of one-dimensional rules for standard normals, or random points if it would be too large."""
    for fewer in range(count, min(count, FEWEST) - 1, -1):
        if fewer**dimension <= (MOST_NODES if fewer > FEWEST else LARGEST):
            return tensor_rule([gauss_hermite(fewer)] * dimension)
    points = np.random.Generator(np.random.Philox(key=SEED)).standard_normal((dimension, POINTS))
    return Rule(points, np.full(POINTS, 1.0 / POINTS), exact=False)


def fifth_degree_rule(n: int) -> Rule:
    """Return a rule for n > 2 standard normals that is exact for polynomials of degree 5, in 2^n + 2n nodes.

    With a^2 = (n + 2)/2 and b^2 = (n + 2)/(n - 2), the points +-a e_i on the axes and the corners b (+-1, ..., +-1)
    of a cube, of weights 1/a^4 and 2^{-n}/b^4 (Stroud 1971, E_n^{r^2} 5-3). Three nodes per variable have the same
    degree with 3^n nodes. Some polynomials of degree 3 vanish at all nodes, such as x_i (x_j^2 - x_k^2), but the
    contribution of an error of degree 3 in the noise of a step to the defect of one step against two half steps does
    not.
    """
    a, b = np.sqrt((n + 2.0) / 2.0), np.sqrt((n + 2.0) / (n - 2.0))
    corners = tensor_rule([(np.array([-b, b]), np.full(2, 0.5))] * n)
    axes = np.concatenate([a * np.eye(n), -a * np.eye(n)], axis=1)
    weights = np.concatenate([corners.weights / b**4, np.full(2 * n, a**-4)])
    return Rule(np.concatenate([corners.x, axes], axis=1), weights)


def orthogonal_rule(n: int) -> Rule:
    """Return a rule of degree 3 for any number n > 2 of standard normals, with at most 4n + 2n nodes.

    The corners of `fifth_degree_rule` are replaced by an orthogonal array of strength 3: the rows of a Hadamard
    matrix and their negatives. It is exact up to degree 3, and for all monomials of degree 4 and 5 except products of
    four different variables. In a system of many equal parts such products might cancel at all nodes, so the rule is
    rotated by an orthogonal matrix, the same for each n, which preserves the degree.
    """
    a, b = np.sqrt((n + 2.0) / 2.0), np.sqrt((n + 2.0) / (n - 2.0))
    signs, axes = _signs(n), np.concatenate([np.eye(n), -np.eye(n)], axis=1)
    count = signs.shape[1]
    weights = np.concatenate([np.full(count, 1.0 / count / b**4), np.full(2 * n, a**-4)])
    return Rule(turn(n, SEED + 6) @ np.concatenate([b * signs, a * axes], axis=1), weights, degree=3)


def _signs(n: int) -> Array:
    """Return an orthogonal array of strength 3: n columns of a Hadamard matrix and their negatives."""
    half = scipy.linalg.hadamard(1 << (n - 1).bit_length())[:, :n].T
    return np.concatenate([half, -half], axis=1)


def resolving_rule(dimension: int, count: int) -> Rule:
    """Return `normal_rule` if it is exact, else `orthogonal_rule`, which also resolves means.

    Parameters
    ----------
    dimension : int
        Number of standard normals.
    count : int
        Largest number of nodes per variable.
    """
    rule = normal_rule(dimension, count)
    return rule if rule.exact else orthogonal_rule(dimension)


def atom_rule(axes: list[tuple[Array, Array]]) -> Rule:
    """Return all atoms of independent variables, given as (values, weights), or random ones if there are too many."""
    if count_atoms(axes) <= LARGEST:
        return tensor_rule(axes)
    rng = np.random.Generator(np.random.Philox(key=SEED))
    points = np.stack([rng.choice(values, size=POINTS, p=weights) for values, weights in axes])
    return Rule(points, np.full(POINTS, 1.0 / POINTS), exact=False)


def count_atoms(axes: list[tuple[Array, Array]]) -> int:
    """Return the number of atoms of independent variables."""
    return prod(len(values) for values, _ in axes)


def other_rule(dimension: int, count: int) -> Rule:
    """Return a rule that shares no node with `normal_rule`: many random nodes, if there are few variables.

    Both give the same mean of a polynomial of low degree. Their means of a function with a jump or a kink differ, and
    those of a function that is different in a small region of the noise, which few nodes miss; see `normal_rule`.
    """
    if dimension in SCATTERED:
        degree, nodes = SCATTERED[dimension]
        return Rule(*scattered(dimension, degree, nodes), degree=degree)
    rule = normal_rule(dimension, count)
    return rule._replace(x=mixing_turn(dimension) @ rule.x)


def step_nodes(dimension: int, count: int, *, areas: bool = False, law: Law = GAUSSIAN, other: bool = False) -> Nodes:
    """Return nodes for the noise of one step.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    count : int
        Largest number of Gauss-Hermite nodes per variable; a discrete law uses its atoms instead.
    areas : bool
        Whether nodes for H are included.
    law : Law
        Law of dW and, if discrete, of H.
    other : bool
        Whether to use `other_rule`; has no effect for a discrete law.

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
    """Return two sets of nodes for the noise of one step that are exact up to degree 3, for all kinds of noise.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    noise : frozenset of str
        Kinds of noise that a scheme uses, of dW, H, K and A.
    law : Law
        Law of dW and, if discrete, of H.

    Returns
    -------
    Nodes, Nodes
        Few nodes, which resolve mean and covariance of a step. For a discrete law both sets are the same; else no
        variable has a value in both.
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
    """Return the variables of a rule as the noise of a step of length 1; `sizes` has their number for each kind."""
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
    """Return Levy areas of a step of length h from standard variables x independent of dW and H.

    Given dW alone they have mean 0 and variance h^2/4. Given H as well, they have the mean H_i dW_j - H_j dW_i and
    the variance h^2/12.

    Parameters
    ----------
    dW : ndarray, shape (l, K)
        Increments.
    H : ndarray, shape (l, K), or None
        Space-time Levy areas, if known.
    x : ndarray, shape (l (l - 1)/2, K)
        Standard variables.
    h : float
        Length of the step.
    """
    return np.asarray(0.5 * h * x if H is None else outer(H, dW) + h / np.sqrt(12.0) * x)


def _signed_rule(n: int, l: int, law: Law) -> Rule:
    """Return a rule of degree 3 from atoms of l variables of a law and n - l signs: all atoms, or signs times sizes.

    Equally probable sizes are used cyclically, with an offset of one more place in each variable.
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
    """Return equally probable absolute values of a symmetric discrete law; None for other laws."""
    sizes, weights = np.abs(law.values), np.array(law.weights)
    if not np.allclose(weights @ (np.sign(law.values)), 0.0):
        return None
    for count in range(1, MOST_SIZES + 1):
        times = np.array([count * weights[sizes == size].sum() for size in np.unique(sizes)])
        if np.allclose(times, np.round(times)):
            return np.repeat(np.unique(sizes), np.round(times).astype(int))
    return None


def cross_with(nodes: Nodes, name: str, data: Any, weights: Array) -> Nodes:
    """Return the product of the nodes with R nodes of an independent record whose probabilities are `weights`.

    Parameters
    ----------
    nodes : Nodes
    name : str
        Name of the record in an increment.
    data : ndarray or record of ndarray, shape (..., R)
        Data of the record at its nodes.
    weights : ndarray, shape (R,)
        Probabilities of the nodes of the record.
    """

    def spread(part: Array) -> Array:
        return np.repeat(part, len(weights), axis=-1)

    records = {**each(spread, nodes.records), name: each(lambda part: np.tile(part, len(nodes.weights)), data)}
    joint = np.multiply.outer(nodes.weights, weights).ravel()
    H, K, A = (each(spread, part) for part in (nodes.H, nodes.K, nodes.A))
    return Nodes(spread(nodes.dW), H, joint, nodes.exact, records, K, A, nodes.degree)


class HalfSteps(NamedTuple):
    """Noise of a step of length 1 and of its two halves, at the same nodes.

    Attributes
    ----------
    whole, first, second : Nodes
        The halves are scaled like the whole step.
    """

    whole: Nodes
    first: Nodes
    second: Nodes

    def with_records(self, records: tuple[NoiseRecord, ...], h: float) -> "HalfSteps":
        """Return nodes that include the noise other than Brownian motions of a step of size h."""
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
    """Return nodes for the Gaussian noise of two half steps and of the whole step.

    dW = dW_1 + dW_2,   H = (H_1 + H_2)/2 + (dW_1 - dW_2)/4,   A = A_1 + A_2 + (dW_1 x dW_2 - dW_2 x dW_1)/2.

    Parameters
    ----------
    dimension : int
        Number l of Brownian motions.
    count : int
        Nodes per normal variable.
    areas : bool
        Whether H is included.
    levy : bool
        Whether Levy areas A are included.
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
    """Return dW and H of two half steps from standard normals; H is None without areas."""
    W1, W2, *rest = np.split(x / np.sqrt(2.0), 4 if areas else 2)
    H1, H2 = (part / np.sqrt(12.0) for part in rest) if areas else (None, None)
    return (W1, W2), (H1, H2)
