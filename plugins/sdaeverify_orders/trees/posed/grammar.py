"""Trees of the nodes of a class, the corresponding integrals of the solution, and distinguishable conditions.

Nodes that are integrals are nodes of an SDE's trees with another name. A product of subtrees,

    I(a_1) ... I(a_n) = sum_i int prod_(j != i) I(a_j) dI(a_i) + sum over pairs of roots of one noise of an int dt,

is a sum of such trees by Ito's formula; below an integral, its factors become factors of that integral.
"""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations

from sdaeverify.trees import Grove, Grown, Node

from ..grow import DRIFT, PRODUCT, TIME, TIME_LEAF, Forest, Tree, multisets, root_weight, tree
from ..moments import Combination

# Colour of a root by its integral; a noise has its number instead.
COLOURS = {"dt": DRIFT, "": PRODUCT}


def grow_nodes(nodes: Sequence[Node], motions: int, top: int) -> list[Tree]:
    """Return all trees of some nodes up to a weight, sorted by weight, each after its subtrees.

    Initial values come first, with the weight 0. A product of a single product is not a tree, and products are
    limited to lower weights, because they enter other components only through an integral node that takes them.

    Parameters
    ----------
    nodes : sequence of Node
    motions : int
        Number of noise colours.
    top : int
        Largest weight.
    """
    components = {node.name: node.of for node in nodes} | {TIME_LEAF.name: "t"}
    last = sorted(nodes, key=lambda node: node.integral == "")
    grown = [tree(PRODUCT, (), node.name) for node in nodes if not (node.integral or node.least)]
    below = {
        node.name: min((_least(each) for each in nodes if node.of in each.takes and each.integral), default=2)
        for node in nodes
    }
    for weight in range(1, top + 1):
        for node in last:
            if node.integral == "" and weight > top - below[node.name]:
                continue
            pool = [each for each in (TIME_LEAF, *grown) if components[each.name] in node.takes]
            pool.sort(key=lambda each: each.weight)
            for colour in range(1, motions + 1) if node.integral == "dW" else (COLOURS[node.integral],):
                some = _kids(node, pool, weight - root_weight(colour))
                grown += [tree(colour, kids, node.name) for kids in some if not _is_alone(colour, kids)]
    return grown


def _least(node: Node) -> int:
    return 1 if node.integral == "dW" else 2


def _kids(node: Node, pool: Sequence[Tree], weight: int) -> Iterator[Forest]:
    if node.most == 0 or (weight == 0 and node.least == 0):
        yield from [()] * (weight == 0)
        return
    if node.most == 1:
        yield from ((each,) for each in pool if each.weight == weight)
        return
    heavy = [each for each in pool if each.weight]
    for places in multisets([each.weight for each in heavy], weight) if weight > 0 else ():
        if node.least <= len(places) <= (node.most or len(places)):
            yield tuple(heavy[i] for i in places)


def _is_alone(colour: int, kids: Forest) -> bool:
    return colour == PRODUCT and len(kids) == 1 and kids[0].colour == PRODUCT


def integral(of: Tree) -> Combination:
    """Return the integral of the solution for a tree, as a combination of trees of an SDE."""
    factors = _factors(of)
    if len(factors) == 1:
        return {factors[0]: Fraction(1)}
    found: dict[Tree, Fraction] = {}
    for i, each in enumerate(factors):
        _count(found, tree(each.colour, (*each.kids, *factors[:i], *factors[i + 1 :])))
    for i, j in combinations(range(len(factors)), 2):
        one, other = factors[i], factors[j]
        if one.colour == other.colour > DRIFT:
            rest = (each for place, each in enumerate(factors) if place not in (i, j))
            _count(found, tree(DRIFT, (*one.kids, *other.kids, *rest)))
    return found


def _count(found: dict[Tree, Fraction], each: Tree) -> None:
    found[each] = found.get(each, Fraction(0)) + 1


def _factors(of: Tree) -> Forest:
    """Return the trees of an SDE whose product a tree is."""
    if of.colour == TIME:
        return (tree(DRIFT),)
    kids = tuple(factor for kid in of.kids for factor in _factors(kid))
    return kids if of.colour == PRODUCT else (tree(of.colour, kids),)


def told_apart(trees: Iterable[Tree], scaled: frozenset[str], top: int) -> dict[tuple[Tree, int], Combination]:
    """Return the distinguishable conditions, keyed by the tree without scaled nodes and the number of these.

    A scaled node is linear and equal for all components. It commutes with all derivatives, so that trees are
    distinguished only by the number of scaled nodes. A condition is named after the tree with its scaled nodes
    nearest to the root.

    Parameters
    ----------
    trees : iterable of Tree
        All trees up to a weight.
    scaled : frozenset of str
        Names of scaled nodes.
    top : int
        Largest weight of `trees`. Products, which do not accumulate over steps, are limited to two less.
    """
    groups: dict[tuple[Tree, int], list[Tree]] = {}
    for each in trees:
        if 0 < each.weight <= (top - 2 if each.colour == PRODUCT else top):
            groups.setdefault(_without(each, scaled), []).append(each)
    found: dict[tuple[Tree, int], Combination] = {}
    for key, same in groups.items():
        name, *others = sorted(same, key=lambda each: _above(each, scaled), reverse=True)
        found[key] = {name: Fraction(1), **{each: Fraction(name.symmetry, each.symmetry) for each in others}}
    return found


def _without(of: Tree, scaled: frozenset[str]) -> tuple[Tree, int]:
    parts = [_without(kid, scaled) for kid in of.kids]
    count = sum(n for _, n in parts)
    if of.name in scaled:
        return parts[0][0], count + 1
    return tree(of.colour, (kid for kid, _ in parts), of.name), count


def without_scaled(of: Tree, nodes: Iterable[Node]) -> Tree:
    """Return a tree with its scaled nodes removed."""
    return _without(of, frozenset(node.name for node in nodes if node.scaled))[0]


def _above(of: Tree, scaled: frozenset[str]) -> int:
    """Return the total weight of subtrees with a scaled root, which is largest for scaled nodes near the root."""
    return (of.weight if of.name in scaled else 0) + sum(_above(kid, scaled) for kid in of.kids)


def sum_of_integrals(of: Combination) -> Combination:
    """Return the integral of the solution for a combination of trees."""
    found: dict[Tree, Fraction] = {}
    for each, c in of.items():
        for part, factor in integral(each).items():
            found[part] = found.get(part, Fraction(0)) + c * factor
    return found


def grove_of(trees: Sequence[Tree], nodes: Sequence[Node], grove: Grove) -> Grove:
    """Return a grove with its trees in the format for forms.

    Parameters
    ----------
    trees : sequence of Tree
        Trees, each after its subtrees.
    nodes : sequence of Node
    grove : Grove
        Grove without trees.
    """
    by_name = {node.name: node for node in nodes}
    places = {TIME_LEAF: -1} | {each: place for place, each in enumerate(trees)}
    grown = (
        Grown(by_name[each.name], max(each.colour, 0) - 1, tuple(places[kid] for kid in each.kids)) for each in trees
    )
    return grove._replace(trees=tuple(grown))
