"""Classes of SDEs as quotients of the space of trees by relations between elementary differentials.

A class is defined by relations sum r_tau F(tau) = 0 that hold for each of its equations. Solving the independent
relations for one tree each leaves a basis of trees tau, and sum Delta(tau)/sigma(tau) F(tau) = 0 becomes one
condition for each tree of the basis:

    Delta(tau) - sum_p r_p,tau sigma(tau)/sigma(p) Delta(p) = 0    where F(p) + sum_tau r_p,tau F(tau) = 0.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

from sdaeverify import IndexOneSDAE, Langevin, Scheme
from sdaeverify.trees import TreeClass

from .grow import DRIFT, TIME, TIME_LEAF, Tree, grow, multisets, root_weight, tree
from .moments import Combination

Relation = dict[Tree, Fraction]


@dataclass(frozen=True)
class EquationClass:
    """A class of SDEs, closed under the operations that a Runge-Kutta method applies to an equation.

    Attributes
    ----------
    name : str
    traits : frozenset of str
        Traits that a problem of the class declares.
    motions : int or None
        Number of Brownian motions; None for any number.
    linear : bool
        Whether coefficients have the form A x + a, constant in time.
    """

    name: str
    traits: frozenset[str] = frozenset()
    motions: int | None = None
    linear: bool = False

    @property
    def additive(self) -> bool:
        """Whether the diffusion is constant."""
        return "additive-noise" in self.traits

    @property
    def diagonal(self) -> bool:
        """Whether each Brownian motion acts on one component, on which alone its coefficient depends."""
        return "diagonal-noise" in self.traits

    @property
    def overdamped(self) -> bool:
        """Whether the drift is a gradient and the noise sigma dW, with conditions of the invariant measure only."""
        return "overdamped-gradient" in self.traits

    @property
    def covers(self) -> str:
        """Further requirements on equations and scheme, in words."""
        if not self.overdamped:
            return ""
        return "drift -grad V, noise sigma dW, both equation and scheme ergodic (Langevin dynamics not included)"

    def trees(self, motions: int, top: int) -> list[Tree]:
        """Return the trees up to a weight, without those whose elementary differential vanishes identically."""
        grown = grow(motions, top, additive=self.additive)
        if self.overdamped:
            return [each for each in grown if TIME not in each.colours]
        if self.linear:
            grown = [each for each in grown if is_straight(each)]
        return [each for each in grown if is_diagonal(each)] if self.diagonal else grown

    def basis(self, trees: Sequence[Tree], motions: int) -> list[Combination]:
        """Return the conditions as combinations of trees, each with the tree that names it first."""
        if self.diagonal:
            return dual_basis(trees, coincidences(trees))
        if not (self.ties and motions):
            return [{each: Fraction(1)} for each in trees]
        return dual_basis(trees, solved_relations(trees, motions, every_pair=self.ties == "vanishing"))

    @property
    def ties(self) -> str:
        """Relation between the products DB_k B_j: "commuting", "vanishing", or empty without a relation."""
        if "vanishing-milstein-term" in self.traits and not self.additive:
            return "vanishing"
        return "commuting" if "commutative-noise" in self.traits else ""


OF_SDES = (
    EquationClass("ode", frozenset({"additive-noise"}), 0),
    EquationClass("scalar", frozenset(), 1),
    EquationClass("additive", frozenset({"additive-noise"})),
    EquationClass("diagonal", frozenset({"diagonal-noise"}), 2),
    EquationClass("commutative", frozenset({"commutative-noise"})),
    EquationClass("vanishing-milstein-term", frozenset({"vanishing-milstein-term", "commutative-noise"})),
    EquationClass("general"),
    EquationClass("overdamped-gradient", frozenset({"overdamped-gradient", "additive-noise"})),
)
# Classes of the framework; forms of plugins offer further ones.
CLASSES: tuple[EquationClass | TreeClass, ...] = (*OF_SDES, *Langevin.tree_classes(), *IndexOneSDAE.tree_classes())


def solved_relations(trees: Sequence[Tree], motions: int, *, every_pair: bool) -> dict[Tree, Relation]:
    """Return the relations of a class, each solved for a tree: F(p) + sum r F(tau) = 0 for the key p.

    The relation DB_k B_j = DB_j B_k, or DB_k B_j = 0, is differentiated in the direction of arbitrary arguments, and
    grafted at arbitrary places of a tree.

    Parameters
    ----------
    trees : sequence of Tree
        All trees up to a weight.
    motions : int
        Number of noise colours.
    every_pair : bool
        Whether each DB_k B_j vanishes, not only the differences.
    """
    solved: dict[Tree, Relation] = {}
    top = max(each.weight for each in trees)
    pairs = [(k, j) for k in range(1, motions + 1) for j in range(1, motions + 1) if every_pair or j < k]
    arguments = [list(_arguments(trees, weight)) for weight in range(top)]
    for weight in range(2, top + 1):
        # Grafting the solved relations suffices, since relations of lower weight have been used in them.
        lower = [(each.weight, {each: Fraction(1), **rest}) for each, rest in solved.items()]
        roots = _roots(arguments[weight - 2], pairs, every_pair=every_pair)
        new = [*roots, *_grafted(arguments, weight, lower, motions)]
        _solve_for_trees(new, solved)
    return solved


def _roots(
    some: Iterable[Sequence[Tree]], pairs: Sequence[tuple[int, int]], *, every_pair: bool
) -> Iterator[Relation]:
    """Yield the derivatives of DB_k B_j, or of DB_k B_j - DB_j B_k, in the direction of given arguments."""
    for arguments in some:
        for k, j in pairs:
            relation = _derived(arguments, k, j)
            if not every_pair:
                for each, c in _derived(arguments, j, k).items():
                    relation[each] = relation.get(each, Fraction(0)) - c
            yield relation


def _arguments(trees: Sequence[Tree], weight: int) -> Iterator[list[Tree]]:
    choices = sorted([TIME_LEAF, *trees], key=lambda each: each.weight)
    for places in multisets([each.weight for each in choices], weight):
        yield [choices[i] for i in places]


def _derived(arguments: Sequence[Tree], k: int, j: int) -> Relation:
    """Return D^S (DB_k B_j) as trees: each argument acts on B_j or on B_k."""
    relation: Relation = {}
    places = range(len(arguments))
    for inner in (some for n in range(len(arguments) + 1) for some in combinations(places, n)):
        below = tree(j, (arguments[i] for i in inner))
        whole = tree(k, (below, *(arguments[i] for i in places if i not in inner)))
        relation[whole] = relation.get(whole, Fraction(0)) + 1
    return relation


def _grafted(
    arguments: Sequence[list[list[Tree]]], weight: int, lower: Iterable[tuple[int, Relation]], motions: int
) -> Iterator[Relation]:
    """Yield relations of lower weight grafted as an argument of a coefficient, with other arguments of any weight."""
    for below, relation in lower:
        for colour in range(motions + 1):
            rest = weight - below - root_weight(colour)
            for others in arguments[rest] if rest >= 0 else ():
                grafted: Relation = {}
                for each, c in relation.items():
                    whole = tree(colour, (each, *others))
                    grafted[whole] = grafted.get(whole, Fraction(0)) + c
                yield grafted


def _solve_for_trees(relations: Iterable[Relation], solved: dict[Tree, Relation]) -> None:
    """Add relations of one weight to the solved ones, keeping these free of solved trees."""
    for relation in relations:
        rest = _reduced(relation, solved)
        if not rest:
            continue
        pivot = max(rest)
        scale = rest.pop(pivot)
        new = {each: c / scale for each, c in rest.items()}
        for other in solved.values():
            if pivot in other:
                _add(other, new, -other.pop(pivot))
        solved[pivot] = new


def _reduced(relation: Relation, solved: dict[Tree, Relation]) -> Relation:
    reduced: Relation = {}
    for each, c in relation.items():
        if each in solved:
            _add(reduced, solved[each], -c)
        else:
            _add(reduced, {each: Fraction(1)}, c)
    return reduced


def _add(to: Relation, other: Relation, scale: Fraction) -> None:
    for each, c in other.items():
        to[each] = to.get(each, Fraction(0)) + scale * c
        if not to[each]:
            del to[each]


def dual_basis(trees: Sequence[Tree], solved: dict[Tree, Relation]) -> list[Combination]:
    """Return the conditions of the quotient by solved relations, one for each remaining tree."""
    found = {each: {each: Fraction(1)} for each in trees if each not in solved}
    for pivot, relation in solved.items():
        for each, c in relation.items():
            found[each][pivot] = -c * Fraction(each.symmetry, pivot.symmetry)
    return list(found.values())


def is_straight(each: Tree) -> bool:
    """Return whether no coefficient is differentiated twice, nor with respect to time."""
    return len(each.kids) <= 1 and all(kid.colour != TIME and is_straight(kid) for kid in each.kids)


def is_diagonal(each: Tree) -> bool:
    """Return whether no noise node has a child of another noise, since b_j depends on the component j alone."""
    moved = {kid.colour for kid in each.kids if kid.colour > DRIFT}
    return (each.colour <= DRIFT or moved <= {each.colour}) and all(map(is_diagonal, each.kids))


def coincidences(trees: Iterable[Tree]) -> dict[Tree, Relation]:
    """Return the relations between trees with equal elementary differentials for diagonal noise."""
    first: dict[object, Tree] = {}
    solved: dict[Tree, Relation] = {}
    for each in trees:
        other = first.setdefault(diagonal_factors(each), each)
        if other is not each:
            solved[each] = {other: Fraction(-1)}
    return solved


def diagonal_factors(each: Tree) -> object:
    """Return the factors of which an elementary differential is the product for diagonal noise.

    A node of noise j is a derivative of b_j with respect to x_j and t, a scalar wherever it stands in the tree. Nodes
    of the drift are coupled by sums over components; such a cluster ends in the root or in a component j.

    Parameters
    ----------
    each : Tree
    """
    numbers: list[tuple[int, int, int]] = []
    clusters: list[tuple[int, Cluster]] = []
    root = _cluster(each, numbers, clusters) if each.colour == DRIFT else _number(each, numbers, clusters)
    return root, tuple(sorted(numbers)), tuple(sorted(clusters))


Cluster = tuple[tuple[int, ...], tuple[Any, ...]]


def _cluster(each: Tree, numbers: list[tuple[int, int, int]], clusters: list[tuple[int, Cluster]]) -> Cluster:
    for kid in each.kids:
        if kid.colour > DRIFT:
            _number(kid, numbers, clusters)
    directions = tuple(sorted(kid.colour for kid in each.kids if kid.colour != DRIFT))
    return directions, tuple(sorted(_cluster(kid, numbers, clusters) for kid in each.kids if kid.colour == DRIFT))


def _number(each: Tree, numbers: list[tuple[int, int, int]], clusters: list[tuple[int, Cluster]]) -> int:
    by_time = sum(kid.colour == TIME for kid in each.kids)
    numbers.append((each.colour, len(each.kids) - by_time, by_time))
    for kid in each.kids:
        if kid.colour == DRIFT:
            clusters.append((each.colour, _cluster(kid, numbers, clusters)))
        elif kid.colour > DRIFT:
            _number(kid, numbers, clusters)
    return each.colour


def tree_classes_of(scheme: Scheme) -> tuple["EquationClass | TreeClass", ...]:
    """Return the classes with order conditions for a scheme: those of its forms, and those of SDEs."""
    own = (kind for form in scheme.forms for kind in form.tree_classes())
    # Without duplicates of classes that the framework's forms offer as well.
    return tuple(dict.fromkeys([*own, *CLASSES]))
