"""Draws of related problems of large size, at late times and among further Brownian motions, for a `TreeClass`.

A step that clips its arguments at some number, that is different at some times, or that ignores further motions, is a
sum over trees near the origin, at one time and with few motions.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ...arrays import Array
from .tree_class import Relatives

# Difference of the times of a step on a problem below and of the step on the problem above it, whose coefficients are
# evaluated later by this amount.
LATER = 0.25
# Time at which steps on trees begin.
TIME_0 = 0.34375
# The size of a distant problem, a power of two so that scaling is exact, and the number of Brownian motions among
# which those of a class are placed.
FAR, PLACES = 2.0**20, 5
# The number of distant pairs, each with its own times; the earliest and the latest time; and their unit, a power
# of two so that a time minus a delay is exact.
TIMES, EARLIEST, LATEST, UNIT = 32, 2.0**-4, 2.0**10, 2.0**-14


def far_states(rng: np.random.Generator, m: int) -> Array:
    """Draw states of a problem of size `FAR`, shape (m, 256).

    A fourth of them have the size `FAR`/8. In the others each component has a random sign and a random size between 1
    and that, so that a step defined differently in some region is evaluated inside and outside of the region.

    Parameters
    ----------
    rng : numpy.random.Generator
    m : int
        Number of components.
    """
    near = FAR / 8.0 * rng.standard_normal((m, 64))
    sizes = np.exp2(rng.uniform(0.0, np.log2(FAR / 8.0), (m, 192)))
    return np.concatenate([near, rng.choice([-1.0, 1.0], sizes.shape) * sizes], axis=1)


def placements(motions: int) -> list[Array]:
    """Return placements of some motions among `PLACES` in their order, as matrices of shape (motions, PLACES).

    They cover each of the `PLACES` motions, and each pair of them if there are at least two.
    """
    size = min(motions, 2)
    ways, left, found = [*combinations(range(PLACES), motions)], {*combinations(range(PLACES), size)}, []
    while left:
        best = max(ways, key=lambda places: len(left.intersection(combinations(places, size))))
        left.difference_update(combinations(best, size))
        found.append(np.eye(PLACES)[list(best)])
    return found


def distant_delays(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Draw the delays of pairs of problems, whose steps begin at times with uniform logarithms, shape (`TIMES`, 2).

    A step that is different in a window of time, or at each k-th multiple of its size, is evaluated inside and
    outside of the window, and with each remainder.

    Parameters
    ----------
    rng : numpy.random.Generator
    """
    drawn = np.exp2(rng.uniform(np.log2(EARLIEST), np.log2(LATEST), (TIMES, 2)))
    return [(first, second) for first, second in (UNIT * np.round(drawn / UNIT) - TIME_0).tolist()]


def among(pairs: Sequence[Relatives], states: Array) -> tuple[Relatives, ...]:
    """Return pairs of problems with the states, shape (m, S), distributed among them."""
    return tuple(pair._replace(states=states[:, k :: len(pairs)]) for k, pair in enumerate(pairs))
