"""Terms of a modified equation as sums over Brownian motions, merging terms that differ only by motions."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from math import perm

from ..grow import DRIFT, Forest, Tree, tree
from .equation import GeneratorTerm


@dataclass(frozen=True)
class Sum:
    """A term, summed over motions.

    Attributes
    ----------
    forest : Forest
        Noise nodes carry the number of their summation index or, without summation, of their motion.
    value, error : float
        Coefficient and its error.
    indices : int
        Number of summation indices.
    distinct : bool
        Whether the indices are pairwise distinct.
    """

    forest: Forest
    value: float
    error: float
    indices: int = 0
    distinct: bool = False


def summed(terms: Iterable[GeneratorTerm], motions: int) -> list[Sum]:
    """Merge terms into sums over motions, if all terms of a sum are present with equal coefficients.

    Parameters
    ----------
    terms : iterable of GeneratorTerm
    motions : int
        Number M of motions.
    """
    found = {each.forest: each for each in terms}
    sums: list[Sum] = []
    while found:
        first = next(iter(found.values()))
        orbit = _orbit(first.forest, motions)
        same = [found.get(forest) for forest in orbit]
        whole = all(each is not None and abs(each.value - first.value) <= each.error + first.error for each in same)
        if whole and motions > 1 and (k := len(_used(first.forest))):
            sums.append(_sum_of(first, orbit, k, motions))
            for forest in orbit:
                del found[forest]
        else:
            sums.append(Sum(first.forest, first.value, first.error))
            del found[first.forest]
    return _merged(sums)


def _sum_of(first: GeneratorTerm, orbit: Sequence[Forest], k: int, motions: int) -> Sum:
    """Return a sum over ordered indices, in which each forest of an orbit occurs equally often."""
    times = perm(motions, k) // len(orbit)
    return Sum(_pattern(first.forest), first.value / times, first.error / times, k, k > 1)


def _merged(sums: list[Sum]) -> list[Sum]:
    """Merge sums over j != k with those over j alone, if the latter are their terms for k = j."""
    merged = list(sums)
    for alone in [each for each in sums if each.indices == 1]:
        parts = [each for each in sums if each.indices == 2 and _joined(each.forest) == alone.forest]
        total = sum(each.value for each in parts)
        if parts and abs(total - alone.value) <= alone.error + sum(each.error for each in parts):
            merged.remove(alone)
            for each in parts:
                merged[merged.index(each)] = Sum(each.forest, each.value, each.error, 2)
    return merged


def _orbit(forest: Forest, motions: int) -> list[Forest]:
    used = _used(forest)
    ways = permutations(range(1, motions + 1), len(used))
    return list(dict.fromkeys(renamed(forest, dict(zip(used, way, strict=True))) for way in ways))


def _used(forest: Forest) -> list[int]:
    return sorted({colour for each in forest for colour in each.colours if colour > DRIFT})


def _pattern(forest: Forest) -> Forest:
    """Return the first forest, in sorted order, with the motions renumbered 1, ..., k."""
    used = _used(forest)
    ways = permutations(range(1, len(used) + 1))
    return min(renamed(forest, dict(zip(used, way, strict=True))) for way in ways)


def _joined(forest: Forest) -> Forest:
    return renamed(forest, dict.fromkeys(_used(forest), 1))


def renamed(forest: Forest, motions: dict[int, int]) -> Forest:
    """Return a forest with renumbered motions, its trees sorted.

    Parameters
    ----------
    forest : Forest
    motions : dict of int to int
        New number of each motion.
    """
    return tuple(sorted(_renamed(forest, motions)))


def _renamed(forest: Iterable[Tree], motions: dict[int, int]) -> Iterator[Tree]:
    for each in forest:
        yield tree(motions.get(each.colour, each.colour), _renamed(each.kids, motions), each.name)
