"""Order conditions: path by path, and of the means of forests.

For a step with defects Delta = phi - I, where the weights are h^(w/2) times functions of the noise divided by
sqrt(h),

    strong order p:  Delta(tau) = 0 on every path for w <= 2p,  and  E Delta(tau) = 0 for w <= 2p + 1
    weak order p:    E prod phi(tau_i) = E prod I(tau_i)  for all forests of weight <= 2p + 1

(Milstein & Tretyakov 2004, sections 1.1 and 2.2; Burrage & Burrage 2000; Roessler 2006; Debrabant & Kvaerno 2008).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, reduce
from math import isnan, nan
from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.probing import Nodes

from .grow import DRIFT, PRODUCT, Forest, Tree, formula, multisets
from .moments import Combination, ExactMoments
from .record import ROUNDING, Record
from .stationary import ForestCombination, stationary_conditions

# Relative tolerance of a weight in units of h^(w/2): rounding is at most 1e-12, updates of Newton's method 1e-10.
TOLERANCE = 1e-8
# Number of forests per batch of products; largest denominator of a fraction; tolerance factor of a fraction.
AT_ONCE, DENOMINATOR, SIMPLE = 512, 48, 1.0
STRONG: str = "strong"
WEAK: str = "weak"
INVARIANT: str = "invariant"


class Condition(NamedTuple):
    """An order condition and its defect.

    Attributes
    ----------
    forest : Forest
        Forest of the condition; a single tree for a condition on paths.
    on_paths : bool
    defect : float
        Defect in units of h^(w/2), relative to the required value; on paths the largest one.
    found : float
        Mean of the step; on paths the factor of the projection of I on the record.
    wanted : Fraction
        Required mean; on paths 1.
    rest : float
        On paths: root mean square of the part not proportional to I.
    known : bool
        Whether I is a function of the record of increments.
    tolerance : float
        Tolerance up to which a defect counts as zero.
    power : float
        Power of h of the defect if weights depend on h; NaN if they do not.
    others : tuple of (Forest, Fraction)
        Further terms of a linear combination of means, after the leading `forest`.
    """

    forest: Forest
    on_paths: bool
    defect: float
    found: float
    wanted: Fraction
    rest: float = 0.0
    known: bool = True
    tolerance: float = TOLERANCE
    power: float = nan
    others: tuple[tuple[Forest, Fraction], ...] = ()

    @property
    def held(self) -> bool:
        """Whether the defect is within the tolerance."""
        return bool(self.defect <= self.tolerance)

    @property
    def weight(self) -> int:
        """Sum of the weights of the trees, twice the order of the terms."""
        return sum(each.weight for each in self.forest)

    @property
    def spent(self) -> int:
        """Shift in weight for conditions on products, which do not accumulate over steps.

        An error of an algebraic component belongs to its step alone; its effect on the other components in the next
        step has one more factor h, or dW with mean 0.
        """
        is_product = any(each.colour == PRODUCT for each in self.forest)
        return (1 if self.on_paths else 2) * is_product

    @property
    def due(self) -> int:
        """Weight of the accumulating conditions that affect the same order: `weight` plus `spent`."""
        return self.weight + self.spent

    @property
    def name(self) -> str:
        """Formula of the forest, or of the combination of forests."""
        return formula(self.forest) + "".join(map(_term, self.others))

    @property
    def texts(self) -> tuple[str, str]:
        """Found and required value in words."""
        if not isnan(self.power):
            return f"off by h^{self.power:.2f}", "I" if self.on_paths else str(self.wanted)
        if not self.on_paths:
            return number_text(self.found, self.tolerance), str(self.wanted)
        if not self.known:
            return "not a function of the record", "I"
        factor = f"{self.found:.4g} I" if abs(self.found) > self.tolerance else "0"
        return (factor if self.rest <= self.tolerance else f"{factor} and {self.rest:.2g} else"), "I"


def _term(other: tuple[Forest, Fraction]) -> str:
    forest, c = other
    size = "" if abs(c) == 1 else f"{abs(c)} "
    return f" {'-' if c < 0 else '+'} {size}{formula(forest)}"


def number_text(value: float, tolerance: float) -> str:
    """Return a number as a fraction if a simple one lies within a tolerance."""
    near = Fraction(value).limit_denominator(DENOMINATOR)
    return str(near) if abs(near - value) < SIMPLE * tolerance else f"{value:.4g}"


class Weighed(NamedTuple):
    """Combinations of weights of steps that correspond to the integrals of the conditions.

    Attributes
    ----------
    psi : ndarray, shape (n, K)
        Combinations of weights, in units of h^(w/2).
    nodes : Nodes
        Noise of a step of length 1.
    """

    psi: Array
    nodes: Nodes


@dataclass(frozen=True, eq=False)
class Conditions:
    """The conditions of a class up to a weight.

    Attributes
    ----------
    trees : sequence of Tree
        Components of the universal SDE.
    basis : sequence of Combination
        Combinations of trees sorted by weight, each with the tree that names it first.
    moments : ExactMoments
    tolerance : float
        Relative tolerance of defects in units of h^(w/2).
    posed : sequence of Combination
        Integrals of the solution for the basis, in trees of an SDE; empty if they are the basis itself.
    tolerances : mapping of int to float
        Tolerances by the weight of trees where these differ from `tolerance`.
    """

    trees: Sequence[Tree]
    basis: Sequence[Combination]
    moments: ExactMoments
    tolerance: float = TOLERANCE
    posed: Sequence[Combination] = ()
    tolerances: Mapping[int, float] = field(default_factory=dict)

    def tolerance_of(self, *weights: int) -> float:
        """Return the relative tolerance of a defect that involves trees of some weights."""
        return max(self.tolerances.get(weight, self.tolerance) for weight in weights)

    @property
    def integrals(self) -> Sequence[Combination]:
        """Integrals of the solution that correspond to the basis."""
        return self.posed or self.basis

    @cached_property
    def names(self) -> list[Tree]:
        """Trees that name the conditions."""
        return [next(iter(each)) for each in self.basis]

    @property
    def weights(self) -> list[int]:
        """Weights of the conditions."""
        return [each.weight for each in self.names]

    def combined(self, phi: Array) -> Array:
        """Return the combinations of weights of trees for the conditions, shape (n, K)."""
        places = {each: place for place, each in enumerate(self.trees)}
        sums = phi[[places[each] for each in self.names]]
        for place, each in enumerate(self.basis):
            for part, c in list(each.items())[1:]:
                sums[place] += float(c) * phi[places[part]]
        return np.asarray(sums)

    def on_paths(self, random: Weighed, rule: Weighed, record: Record, top: int) -> Iterator[Condition]:
        """Yield the conditions on paths up to a weight.

        Parameters
        ----------
        random : Weighed
            Weights at random points, where only the zero polynomial vanishes.
        rule : Weighed
            Weights at the nodes of a quadrature rule for expectations.
        record : Record
        top : int
        """
        for (_, parity), places in sorted(self._groups(top).items()):
            some = [self.integrals[i] for i in places]
            projection = record.projected(some, max(map(_noises, some)), parity)
            wanted, at_rule = (record.values(projection, each.nodes) for each in (random, rule))
            for n, i in enumerate(places):
                factor, rest = _part_of(rule.psi[i], at_rule[n], rule.nodes.weights)
                off = float(np.max(np.abs(random.psi[i] - wanted[n]) / (1.0 + np.abs(wanted[n]))))
                known = bool(projection.distances[n] < ROUNDING)
                defect = off if known else max(off, float(projection.distances[n]) ** 0.5)
                tolerance = self.tolerance_of(self.weights[i])
                yield Condition((self.names[i],), True, defect, factor, Fraction(1), rest, known, tolerance)

    def _groups(self, top: int) -> dict[tuple[int, int], list[int]]:
        groups: dict[tuple[int, int], list[int]] = {}
        for place, each in enumerate(self.integrals):
            if self.weights[place] <= top:
                parity = self.moments.parity((next(iter(each)),))
                groups.setdefault((self.weights[place], parity), []).append(place)
        return groups

    def of_means(self, rule: Weighed, forests: Sequence[tuple[int, ...]]) -> list[Condition]:
        """Return the conditions on means of forests, given as indices into the basis."""
        found = means_of_products(rule.psi, rule.nodes.weights, forests)
        return [self._mean_condition(places, value) for places, value in zip(forests, found, strict=True)]

    def _mean_condition(self, places: tuple[int, ...], found: float) -> Condition:
        if self._is_plain:
            wanted = self.moments.mean(next(iter(self.integrals[i])) for i in places)
        else:
            wanted = self.moments.mean_of_product(self.integrals[i] for i in places)
        defect = abs(found - float(wanted)) / (1.0 + abs(float(wanted)))
        names = tuple(self.names[i] for i in places)
        tolerance = self.tolerance_of(*(each.weight for each in names))
        return Condition(names, False, defect, float(found), wanted, tolerance=tolerance)

    @cached_property
    def stationary(self) -> list[ForestCombination]:
        """Combinations of means on which the invariant measure depends."""
        motions = max(each.colour for each in self.trees)
        return stationary_conditions(self.trees, motions, max(each.weight for each in self.trees))

    def of_stationary(self, rule: Weighed) -> list[Condition]:
        """Return the conditions of the invariant measure, for a basis of single trees."""
        combinations = self.stationary
        places = {each: place for place, each in enumerate(self.names)}
        forests = list({forest: None for some in combinations for forest in some})
        rows = [tuple(places[each] for each in forest) for forest in forests]
        found = dict(zip(forests, map(float, means_of_products(rule.psi, rule.nodes.weights, rows)), strict=True))
        return [self._combined_condition(some, found) for some in combinations]

    def _combined_condition(self, combination: ForestCombination, found: Mapping[Forest, float]) -> Condition:
        wanted = {forest: self.moments.mean(forest) for forest in combination}
        # Forests of increments almost always have the right moments, so they are omitted from the text.
        told = {
            forest: c
            for forest, c in combination.items()
            if not _is_increments(forest) or abs(found[forest] - wanted[forest]) > self.tolerance
        }
        terms = told or combination
        first, *others = terms.items()
        mean = sum(float(c) * found[forest] for forest, c in terms.items()) / float(first[1])
        exact = sum((c * wanted[forest] for forest, c in terms.items()), Fraction(0)) / first[1]
        rest = tuple((forest, c / first[1]) for forest, c in others)
        defect = abs(mean - float(exact)) / (1.0 + abs(float(exact)))
        return Condition(first[0], False, defect, mean, exact, tolerance=self.tolerance, others=rest)

    @cached_property
    def _is_plain(self) -> bool:
        return all(list(each.values()) == [1] for each in self.integrals)

    def forests(self, top: int) -> list[tuple[int, ...]]:
        """Return all forests up to a weight, as indices into the basis, by weight; with a product up to two less."""
        added = [i for i, each in enumerate(self.names) if each.colour != PRODUCT]
        weights = [self.weights[i] for i in added]
        low = [places for weight in range(1, top - 1) for places in multisets(self.weights, weight)]
        high = (places for weight in range(max(1, top - 1), top + 1) for places in multisets(weights, weight))
        return [*low, *(tuple(added[i] for i in places) for places in high)]


def _is_increments(forest: Forest) -> bool:
    return all(not each.kids for each in forest)


def _noises(of: Combination) -> int:
    """Return the largest number of noise nodes in a tree; its integral is orthogonal to higher polynomials."""
    return max(sum(colour > DRIFT for colour in each.colours) for each in of)


def _part_of(found: Array, wanted: Array, weights: Array) -> tuple[float, float]:
    """Return the multiple of `wanted` nearest to `found` in mean square, and the remaining distance."""
    square = float((wanted * wanted) @ weights)
    factor = float((found * wanted) @ weights) / square if square > ROUNDING else 0.0
    return factor, float(np.sqrt((found - factor * wanted) ** 2 @ weights))


def means_of_products(psi: Array, weights: Array, forests: Sequence[tuple[int, ...]]) -> Array:
    """Return the expectations of products of rows, shape (F,).

    Parameters
    ----------
    psi : ndarray, shape (n, K)
    weights : ndarray, shape (K,)
        Probability weights of the nodes.
    forests : sequence of tuple of int
        Indices of the rows to multiply.
    """
    means = np.empty(len(forests))
    by_length: dict[int, list[int]] = {}
    for place, forest in enumerate(forests):
        by_length.setdefault(len(forest), []).append(place)
    for places in by_length.values():
        for begin in range(0, len(places), AT_ONCE):
            some = places[begin : begin + AT_ONCE]
            rows = np.array([forests[i] for i in some])
            means[some] = reduce(np.multiply, (psi[column] for column in rows.T)) @ weights
    return means


def order_of(conditions: Sequence[Condition], top: int, measure: str) -> float:
    """Return the largest order up to (top - 1)/2 whose conditions hold, or 0.

    Parameters
    ----------
    conditions : sequence of Condition
    top : int
        Largest examined weight.
    measure : str
        ``strong``, ``weak`` or ``invariant``.
    """
    failing = [each for each in conditions if not each.held]
    for twice in range(1, top):
        if any(belongs(each, measure, 0.5 * twice) for each in failing):
            return 0.5 * (twice - 1)
    return 0.5 * (top - 1)


def belongs(condition: Condition, measure: str, p: float) -> bool:
    """Return whether a condition is required for order p.

    Parameters
    ----------
    condition : Condition
    measure : str
        ``strong``, ``weak`` or ``invariant``.
    p : float
    """
    if measure != STRONG:
        return not condition.on_paths and condition.due <= 2 * p + 1
    if condition.on_paths:
        return condition.due <= 2 * p
    return len(condition.forest) == 1 and condition.due <= 2 * p + 1


def breaking(conditions: Sequence[Condition], measure: str) -> list[Condition]:
    """Return the conditions of a measure that do not hold, lowest order first.

    Parameters
    ----------
    conditions : sequence of Condition
    measure : str
    """
    every = max((each.due for each in conditions), default=0)
    failing = [each for each in conditions if not each.held and belongs(each, measure, every)]
    return sorted(failing, key=lambda each: (each.due - (not each.on_paths), len(each.forest), len(each.name)))
