"""Integrations by parts against exp(phi): what is left of derivatives of u is a polynomial in derivatives of phi."""

from collections.abc import Iterable, Iterator
from itertools import product

from ..grow import DRIFT, Forest, Tree

# A product of derivatives of phi by coordinates 1, ..., d, each sorted, and a polynomial of such with whole numbers.
Monomial = tuple[tuple[int, ...], ...]
Polynomial = dict[Monomial, int]


def by_parts(forest: Forest, dimension: int) -> Polynomial:
    """Return q with int D^n u (F(tau_1), ..., F(tau_n)) exp(phi) dx = int u q exp(phi) dx, but for a factor.

    The factor sqrt(2) of an odd number of noise nodes is left out.

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
    """Yield the terms of F(tau), each with its component and factors; the vectors of noise have length 1."""
    if each.colour > DRIFT:
        yield each.colour, ()
        return
    for below in product(*(_components(kid, dimension) for kid in each.kids)):
        directions = [direction for direction, _ in below]
        factors = [factor for _, some in below for factor in some]
        for i in range(1, dimension + 1):
            yield i, (tuple(sorted((i, *directions))), *factors)


def _moved(q: Polynomial, direction: int) -> Polynomial:
    """Return -(d_i q + q d_i phi): what a derivative of u leaves of q."""
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
