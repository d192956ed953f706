"""Conditions of the invariant measure of overdamped dynamics dx = -grad V dt + sigma dW.

With E u(x+) = u + h A_0 u + h^2 A_1 u + ... a scheme has the invariant density rho = exp(-2 V/sigma^2)/Z up to the
order p if the integrals of A_j u against rho vanish for all u and j < p (Abdulle, Vilmart & Zygalakis 2014, theorem
3.3). Those of the solution do, so that the defects Delta of the means of forests have to satisfy, weight by weight,

    sum over forests of  Delta(F)/sigma(F)  int D^n u (F(tau_1), ..., F(tau_n)) rho dx = 0     for all u and V.

Integration by parts removes all derivatives from u and leaves polynomials in derivatives of V. Each of their
coefficients is a linear equation for the Delta (Laurent & Vilmart 2020, whose exotic aromatic trees are these terms).
The power of sigma is determined by the number of factors V. Therefore sigma^2 = 2 is no restriction, and rho is then
exp(phi) with the drift grad phi.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import factorial, prod

from .grow import DRIFT, Forest, Tree, multisets

# A product of derivatives of phi by coordinates 1, ..., d, each sorted, and a polynomial of these over the integers.
Monomial = tuple[tuple[int, ...], ...]
Polynomial = dict[Monomial, int]
# A linear combination of means of forests of one weight, beginning with the forest that names it.
ForestCombination = dict[Forest, Fraction]


def stationary_conditions(trees: Sequence[Tree], motions: int, top: int) -> list[ForestCombination]:
    """Return the independent conditions on means of forests, by weight.

    Parameters
    ----------
    trees : sequence of Tree
        Trees of additive noise without leaves of time, sorted by weight.
    motions : int
        Number d of Brownian motions and of components.
    top : int
        Largest weight.
    """
    weights = [each.weight for each in trees]
    found: list[ForestCombination] = []
    for weight in range(1, top + 1):
        forests = [tuple(trees[i] for i in places) for places in multisets(weights, weight)]
        # Conditions are solved for the means of forests with few, large trees.
        found += _solved(sorted(sorted(forests, reverse=True), key=len), motions)
    return found


def _solved(forests: Sequence[Forest], motions: int) -> list[ForestCombination]:
    """Return a basis of the equations of some forests of one weight, each solved for its first forest."""
    place = {forest: i for i, forest in enumerate(forests)}
    equations: dict[Monomial, dict[int, Fraction]] = {}
    for forest in forests:
        share = Fraction(1, forest_symmetry(forest))
        for monomial, c in by_parts(forest, motions).items():
            equations.setdefault(monomial, {})[place[forest]] = share * c
    solved: dict[int, dict[int, Fraction]] = {}
    for equation in equations.values():
        _solve(equation, solved)
    return [{forests[i]: c for i, c in sorted(row.items())} for _, row in sorted(solved.items())]


def _solve(equation: dict[int, Fraction], solved: dict[int, dict[int, Fraction]]) -> None:
    """Add an equation to the solved ones, keeping each free of the first unknowns of the others."""
    rest = dict(equation)
    for pivot in [each for each in equation if each in solved]:
        _add(rest, solved[pivot], -rest[pivot])
    if not rest:
        return
    first = min(rest)
    row = {i: c / rest[first] for i, c in rest.items()}
    for other in solved.values():
        if first in other:
            _add(other, row, -other[first])
    solved[first] = row


def _add(to: dict[int, Fraction], other: dict[int, Fraction], scale: Fraction) -> None:
    for i, c in other.items():
        if total := to.get(i, Fraction(0)) + scale * c:
            to[i] = total
        else:
            to.pop(i, None)


def forest_symmetry(forest: Forest) -> int:
    """Return the number of permutations of nodes that leave a forest unchanged."""
    counts = Counter(forest)
    return prod(factorial(n) * each.symmetry**n for each, n in counts.items())


def by_parts(forest: Forest, dimension: int) -> Polynomial:
    """Return q with int D^n u (F(tau_1), ..., F(tau_n)) exp(phi) dx = int u q exp(phi) dx, up to a factor.

    The factor sqrt(2) for an odd number of noise nodes is omitted.

    Parameters
    ----------
    forest : Forest
    dimension : int
    """
    noises = sum(colour > DRIFT for each in forest for colour in each.colours)
    total: Polynomial = {}
    for components in product(*(_components(each, dimension) for each in forest)):
        q: Polynomial = {(): 2 ** (noises // 2)}
        for _, factors in components:
            q = {_sorted((*monomial, *factors)): c for monomial, c in q.items()}
        for direction, _ in components:
            q = _moved(q, direction)
        _sum(total, q.items())
    return {monomial: c for monomial, c in total.items() if c}


def _components(each: Tree, dimension: int) -> Iterator[tuple[int, Monomial]]:
    """Yield the terms of F(tau), each with its component and factors, for noise vectors of length 1."""
    if each.colour > DRIFT:
        yield each.colour, ()
        return
    for below in product(*(_components(kid, dimension) for kid in each.kids)):
        directions = [direction for direction, _ in below]
        factors = [factor for _, some in below for factor in some]
        for i in range(1, dimension + 1):
            yield i, (tuple(sorted((i, *directions))), *factors)


def _moved(q: Polynomial, direction: int) -> Polynomial:
    """Return -(d_i q + q d_i phi), the result of moving a derivative from u to q."""
    moved: Polynomial = {}
    for monomial, c in q.items():
        _sum(moved, [(_sorted((*monomial, (direction,))), -c)])
        for place, factor in enumerate(monomial):
            further = tuple(sorted((*factor, direction)))
            _sum(moved, [(_sorted((*monomial[:place], further, *monomial[place + 1 :])), -c)])
    return moved


def _sum(to: Polynomial, terms: Iterable[tuple[Monomial, int]]) -> None:
    for monomial, c in terms:
        to[monomial] = to.get(monomial, 0) + c


def _sorted(factors: Iterable[tuple[int, ...]]) -> Monomial:
    return tuple(sorted(factors))
