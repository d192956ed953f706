"""Projection of iterated integrals on polynomials of the record of increments of a step.

The record of a step of length 1 consists of iterated integrals,

    dW_j = I(b_j),  H_j + dW_j/2 = I(f(b_j)),  dW_j/3 + H_j/2 - K_j = I(f(b_j,t)),  A_ij + dW_i dW_j/2 = I(b_j(b_i)),

so that all products needed for a projection are moments of forests. An integral that is not a function of the record
has a best approximation at a positive distance: no scheme with this record can reproduce it on each path.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.probing import Nodes

from .grow import DRIFT, TIME_LEAF, Forest, Tree, multisets, tree
from .moments import Combination, ExactMoments

# Rounding error of a variance computed from moments of size 1.
ROUNDING = 1e-9


class RecordedIntegral(NamedTuple):
    """A random variable of the record.

    Attributes
    ----------
    integral : Tree
        Tree whose I over a step of length 1 is the variable.
    degree : int
        Power of sqrt(h) by which the variable scales with the length of a step.
    value : callable, Nodes -> ndarray, shape (K,)
    """

    integral: Tree
    degree: int
    value: Callable[[Nodes], Array]


class Projection(NamedTuple):
    """Projection of integrals of one parity on the record.

    Attributes
    ----------
    monomials : list of Forest
        Products of variables of the record.
    coefficients : ndarray, shape (n, m)
        Coefficient of each monomial for each of n integrals.
    distances : ndarray, shape (n,)
        Variances of the residuals.
    """

    monomials: list[Forest]
    coefficients: Array
    distances: Array


@dataclass(frozen=True, eq=False)
class Record:
    """Noise of a step as iterated integrals.

    Attributes
    ----------
    noise : frozenset of str
        Which of dW, H, K and A a scheme uses.
    motions : int
    moments : ExactMoments
    """

    noise: frozenset[str]
    motions: int
    moments: ExactMoments

    @property
    def entries(self) -> dict[Tree, RecordedIntegral]:
        """All variables of the record by their integrals, those of degree 1 first."""
        linear = [part for j in range(self.motions) for part in _of_motion(j, self.noise)]
        pairs = enumerate(combinations(range(self.motions), 2)) if "A" in self.noise else ()
        areas = [_area(place, i, j) for place, (i, j) in pairs]
        return {each.integral: each for each in (*linear, *areas)}

    def monomials(self, degree: int, parity: int) -> list[Forest]:
        """Return the products of variables of the record up to a degree with a given bit mask of odd noises."""
        entries = list(self.entries)
        degrees = [self.entries[each].degree for each in entries]
        some = (multisets(degrees, n) for n in range(degree % 2, degree + 1, 2))
        forests = (tuple(entries[i] for i in places) for each in some for places in each)
        return [forest for forest in forests if self.moments.parity(forest) == parity]

    def projected(self, of: Sequence[Combination], degree: int, parity: int) -> Projection:
        """Return the projections of combinations of integrals of one parity on the record.

        Parameters
        ----------
        of : sequence of Combination
            Combinations of trees of one weight.
        degree : int
            Largest number of noise nodes in a tree; the integrals are orthogonal to Hermite polynomials beyond it.
        parity : int
            Bit mask of the noises with an odd number of nodes.
        """
        monomials = self.monomials(degree, parity)
        mean = self.moments.mean_of_product
        gram = np.array([[float(self.moments.mean(a + b)) for b in monomials] for a in monomials])
        mixed = np.array([[float(_mean_with(self.moments, each, a)) for a in monomials] for each in of])
        squares = np.array([float(mean((each, each))) for each in of])
        if not monomials:
            return Projection([], np.zeros((len(of), 0)), squares)
        coefficients = np.linalg.solve(gram, mixed.T).T
        return Projection(monomials, coefficients, squares - np.sum(coefficients * mixed, axis=1))

    def values(self, projection: Projection, nodes: Nodes) -> Array:
        """Evaluate the projections for noise of a step of length 1, shape (n, K)."""
        count = nodes.dW.shape[1]
        entries = {each: entry.value(nodes) for each, entry in self.entries.items()}
        products = [
            np.prod([np.ones(count), *(entries[each] for each in forest)], axis=0) for forest in projection[0]
        ]
        return np.asarray(projection.coefficients @ np.array(products).reshape(-1, count))


def _mean_with(moments: ExactMoments, of: Combination, forest: Forest) -> float:
    return float(sum(c * moments.mean((each, *forest)) for each, c in of.items()))


def _of_motion(j: int, noise: frozenset[str]) -> list[RecordedIntegral]:
    b = tree(j + 1)
    entries = [RecordedIntegral(b, 1, lambda nodes: nodes.dW[j])]
    if "H" in noise:
        entries.append(RecordedIntegral(tree(DRIFT, (b,)), 1, lambda nodes: _of(nodes.H)[j] + nodes.dW[j] / 2.0))
    if "K" in noise:
        integral = tree(DRIFT, (b, TIME_LEAF))
        entries.append(RecordedIntegral(integral, 1, lambda n: n.dW[j] / 3.0 + _of(n.H)[j] / 2.0 - _of(n.K)[j]))
    return entries


def _area(place: int, i: int, j: int) -> RecordedIntegral:
    integral = tree(j + 1, (tree(i + 1),))
    return RecordedIntegral(integral, 2, lambda nodes: _of(nodes.A)[place] + nodes.dW[i] * nodes.dW[j] / 2.0)


def _of(part: Array | None) -> Array:
    assert part is not None
    return part
