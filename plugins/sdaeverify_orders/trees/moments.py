"""Exact moments of iterated integrals: E prod I(tau_i) over a step of length 1.

By Ito's formula the derivative of E prod I with respect to the length is a sum over one removed drift root, and over
pairs of removed roots of the same noise; the remaining forest has the weight w - 2. Each moment is a power of the
length, so that N = (w/2)! E is the sum of the N of the remaining forests: an integer, 1 for the empty forest.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from math import factorial, prod

from .grow import DRIFT, TIME, Forest, Tree

# A linear combination of trees of one weight.
Combination = Mapping[Tree, Fraction]


@dataclass(frozen=True)
class ExactMoments:
    """Cache of the exact moments of forests, with numbered trees; time is a drift of 1.

    Attributes
    ----------
    places : dict of Tree to int
        Number of each tree.
    nodes : list of (int, tuple of int, int)
        By number: colour of the root, subtrees, and a bit mask of the noises with an odd number of nodes.
    known : dict of tuple of int to int
        N of forests computed so far.
    """

    places: dict[Tree, int] = field(default_factory=dict)
    nodes: list[tuple[int, tuple[int, ...], int]] = field(default_factory=list)
    known: dict[tuple[int, ...], int] = field(default_factory=lambda: {(): 1})

    def mean(self, forest: Iterable[Tree]) -> Fraction:
        """Return E prod I(tau_i) over the trees of a forest."""
        trees = tuple(forest)
        weight = sum(each.weight for each in trees)
        if self.parity(trees):
            return Fraction(0)
        return Fraction(self._count(tuple(sorted(map(self.place, trees)))), factorial(weight // 2))

    def mean_of_product(self, factors: Iterable[Combination]) -> Fraction:
        """Return E prod sum c I(tau) over linear combinations of trees, each of trees of one weight and parity."""
        some = [[*each.items()] for each in factors]
        first = tuple(each[0][0] for each in some)
        if self.parity(first):
            return Fraction(0)
        numbered = ([(_whole(c), self.place(each)) for each, c in items] for items in some)
        total: Fraction | int = 0
        for term in product(*numbered):
            total += prod(c for c, _ in term) * self._count(tuple(sorted(place for _, place in term)))
        return Fraction(total, factorial(sum(each.weight for each in first) // 2))

    def parity(self, forest: Forest) -> int:
        """Return the bit mask of noises with an odd number of nodes; the moment vanishes unless it is 0."""
        odd = 0
        for each in forest:
            odd ^= self.nodes[self.place(each)][2]
        return odd

    def place(self, each: Tree) -> int:
        """Return the number of a tree, assigning one if it is new."""
        place = self.places.get(each)
        if place is None:
            colour = DRIFT if each.colour == TIME else each.colour
            kids = tuple(map(self.place, each.kids))
            odd = (1 << colour) >> 1
            for kid in kids:
                odd ^= self.nodes[kid][2]
            place = self.places[each] = self._numbered((colour, kids, odd))
        return place

    def _numbered(self, node: tuple[int, tuple[int, ...], int]) -> int:
        # The leaf f has the number of the leaf t, because both integrals are the elapsed time.
        if node == (DRIFT, (), 0) and node in self.nodes:
            return self.nodes.index(node)
        self.nodes.append(node)
        return len(self.nodes) - 1

    def _count(self, forest: tuple[int, ...]) -> int:
        known = self.known.get(forest)
        if known is None:
            known = self.known[forest] = sum(map(self._count, self._derivative(forest)))
        return known

    def _derivative(self, forest: tuple[int, ...]) -> list[tuple[int, ...]]:
        left = []
        for i, first in enumerate(forest):
            colour, kids, _ = self.nodes[first]
            others = forest[:i] + forest[i + 1 :]
            if colour == DRIFT:
                left.append(tuple(sorted(others + kids)))
                continue
            for j in range(i, len(others)):
                other, more, _ = self.nodes[others[j]]
                if other == colour:
                    left.append(tuple(sorted(others[:j] + others[j + 1 :] + kids + more)))
        return left


def _whole(c: Fraction) -> Fraction | int:
    """Convert a fraction to an integer if it is one, because integers are faster."""
    return c.numerator if c.denominator == 1 else c
