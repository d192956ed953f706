"""Rooted trees with coloured nodes: 0 the drift f, j > 0 the column b_j of the diffusion, and leaves t for time.

The tree [tau_1, ..., tau_k]_c is the elementary differential D^k c (F(tau_1), ..., F(tau_k)) of the coefficient c; a
leaf t is a derivative with respect to time. The weight of a tree is twice its order in h: 1 for each noise node, 2
for each other node. Equations of other forms have nodes with other names (`posed`); some of these are products of
their subtrees and have weight 0.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from math import factorial, prod
from typing import NamedTuple

PRODUCT, TIME, DRIFT = -2, -1, 0


class Tree(NamedTuple):
    """A rooted tree.

    Attributes
    ----------
    colour : int
        Colour of the root: -1 time, 0 drift, j > 0 the j-th noise, -2 a product.
    kids : tuple of Tree
        Subtrees at the root, sorted.
    name : str
        Symbol of the root without the number of a noise; empty for t, f and b.
    weight : int
        Sum of the weights of all nodes, twice the order in h.
    """

    colour: int
    kids: "tuple[Tree, ...]"
    name: str
    weight: int

    def __str__(self) -> str:
        inside = ",".join(map(str, self.kids))
        return self.root + (f"({inside})" if inside else "")

    @property
    def root(self) -> str:
        """Symbol of the root."""
        return node_name(self.colour, self.name)

    @property
    def symmetry(self) -> int:
        """Number sigma of permutations of nodes that leave the tree unchanged."""
        counts = Counter(self.kids)
        return prod(factorial(n) * kid.symmetry**n for kid, n in counts.items())

    @property
    def colours(self) -> Iterator[int]:
        """Colours of all nodes."""
        yield self.colour
        for kid in self.kids:
            yield from kid.colours

    @property
    def subtrees(self) -> "Iterator[Tree]":
        """All subtrees, each before the tree that contains it, without leaves of time."""
        for kid in self.kids:
            yield from kid.subtrees
        if self.colour != TIME:
            yield self


Forest = tuple[Tree, ...]


def root_weight(colour: int) -> int:
    """Return the weight of a node: 1 for noise, 0 for a product, otherwise 2."""
    if colour > DRIFT:
        return 1
    return 0 if colour == PRODUCT else 2


def node_name(colour: int, name: str = "") -> str:
    """Return the symbol of a node: t, f, b1, b2, ..., or one with another name."""
    if colour > DRIFT:
        return f"{name or 'b'}{colour}"
    return name or {TIME: "t", DRIFT: "f"}[colour]


def tree(colour: int, kids: Iterable[Tree] = (), name: str = "") -> Tree:
    """Create a tree from its root colour and subtrees in any order.

    Parameters
    ----------
    colour : int
    kids : iterable of Tree
    name : str
        Symbol of the root, if it is not t, f or b.
    """
    below = tuple(sorted(kids))
    return Tree(colour, below, name, root_weight(colour) + sum(each.weight for each in below))


TIME_LEAF = tree(TIME)


def formula(forest: Iterable[Tree]) -> str:
    """Return a forest as a product: ``b1 . b1(t)``."""
    return " . ".join(map(str, forest))


def picture(of: Tree) -> list[str]:
    """Return the lines of a drawing of a tree, root first."""
    lines = [of.root]
    for place, kid in enumerate(of.kids):
        first, further = ("└─ ", "   ") if place == len(of.kids) - 1 else ("├─ ", "│  ")
        head, *rest = picture(kid)
        lines += [first + head, *(further + line for line in rest)]
    return lines


def grow(motions: int, top: int, *, additive: bool = False) -> list[Tree]:
    """Return all trees up to a weight, sorted by weight, each after its subtrees.

    Parameters
    ----------
    motions : int
        Number M of noise colours.
    top : int
        Largest weight.
    additive : bool
        Whether noise nodes are leaves, because the diffusion is constant.
    """
    grown: list[Tree] = []
    for weight in range(1, top + 1):
        kids = sorted([TIME_LEAF, *grown], key=lambda each: each.weight)
        weights = [each.weight for each in kids]
        for colour in range(motions + 1):
            rest = weight - root_weight(colour)
            if rest == 0 or (rest > 0 and not (additive and colour > DRIFT)):
                grown += [tree(colour, (kids[i] for i in some)) for some in multisets(weights, rest)]
    return grown


def closure(trees: Iterable[Tree]) -> list[Tree]:
    """Return trees with all their subtrees, without duplicates, each after its subtrees."""
    return list(dict.fromkeys(part for each in trees for part in each.subtrees))


def closed_sets(trees: Sequence[Tree], size: int) -> list[list[Tree]]:
    """Return closed sets of about `size` trees at most that together contain all trees."""
    sets: list[dict[Tree, None]] = [{}]
    for each in reversed(trees):
        if any(each in some for some in sets):
            continue
        if len(sets[-1]) + len(parts := closure([each])) > size:
            sets.append({})
        sets[-1].update(dict.fromkeys(parts))
    return [list(some) for some in sets]


def multisets(weights: Sequence[int], total: int, start: int = 0) -> Iterator[tuple[int, ...]]:
    """Yield the multisets of indices whose weights have a given sum, as sorted tuples.

    Parameters
    ----------
    weights : sequence of int
        Positive weights in ascending order.
    total : int
    start : int
        Least index.
    """
    if total == 0:
        yield ()
    for place in range(start, len(weights)):
        if weights[place] > total:
            return
        for rest in multisets(weights, total - weights[place], place):
            yield (place, *rest)
