"""Many repetitions of a measurement in one block: the tallies of parts of its paths, one after the other.

A repetition of UNIT paths is the smallest sample; neighbouring ones are pooled into larger samples. Stacked tallies
are tallies whose arrays have the repetition as first axis. Statistics are taken of many repetitions at once, and true
values from repetitions that are independent of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from sdaeverify import Array, Parts, Problem, Settings
from sdaeverify.measuring import Estimate, Measure, Observer, Snapshot, Tally
from sdaeverify.numerics import GROUPS, pseudo_values

UNIT = 100
# Repetitions of the longest sample.
POOLED = 16


class Divisible(Observer, Protocol):
    """A notebook that can tell about some of its paths."""

    def part(self, paths: slice) -> Observer:
        """Return what was noted on some of the paths."""
        ...


@dataclass(frozen=True)
class Repeated(Measure):
    """Notes what another measure notes, for each repetition by itself.

    Attributes
    ----------
    measure : Measure
        Its observers are `Divisible`.
    """

    measure: Any

    name: ClassVar[str] = "repeated"

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> "RepeatedObserver":
        """Return the notebook for one block."""
        # What depends on the size of the sample is for the longest one, not for the whole block.
        return RepeatedObserver(self.measure.observer(problem, parts, replace(settings, paths=UNIT * POOLED)))


class RepeatedObserver:
    """Passes on what it is shown, and takes the notes apart at the end."""

    def __init__(self, inner: Divisible) -> None:
        self.inner, self.wanted, self.paths = inner, inner.wanted, 0

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Pass on the step."""
        self.inner.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Pass on the states."""
        self.paths = max(part.shape[-1] for part in snapshot.levels[0].values())
        self.inner.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the stacked tallies of all whole repetitions."""
        starts = range(0, self.paths - UNIT + 1, UNIT)
        return stack_tallies([self.inner.part(slice(start, start + UNIT)).tally() for start in starts])


def stack_tallies(tallies: Sequence[Tally]) -> Tally:
    """Return the tallies of several repetitions as one."""
    return _join(tallies, np.stack)


def append_tallies(tallies: Sequence[Tally]) -> Tally:
    """Return several stacked tallies one after the other."""
    return _join(tallies, np.concatenate)


def pool(tally: Tally, count: int, every: int | None = None) -> Tally:
    """Pool the first `count` of every `every` neighbouring repetitions (of every `count` if left out).

    Parameters
    ----------
    tally : Tally
        Sums and maxima with the repetitions first.
    count : int
        Repetitions that make up one larger sample.
    every : int, optional
        Distance of the first repetitions of two samples: more than `count` leaves the rest unused.
    """
    every = every or count

    def runs(values: Array) -> Array:
        return values.reshape(-1, every, *values.shape[1:])[:, :count]

    def tops(values: Array) -> Array:
        every_one = np.sort(np.concatenate(np.moveaxis(runs(values), 1, 0), axis=-1), axis=-1)
        return every_one[..., ::-1][..., : values.shape[-1]]

    return Tally(
        _map_values(tally.sums, lambda values: runs(values).sum(axis=1)),
        _map_values(tally.maxima, lambda values: runs(values).max(axis=1)),
        _map_values(tally.largest, tops),
    )


def one(tally: Tally, repetition: int) -> Tally:
    """Return the tally of one repetition."""
    return _join([tally], lambda values: np.asarray(values[0][repetition]))


def _join(tallies: Sequence[Tally], join: Callable[[list[Array]], Array]) -> Tally:
    def join_maps(kind: str) -> dict[str, Array]:
        maps: list[Mapping[str, Array]] = [getattr(tally, kind) for tally in tallies]
        return {name: join([values[name] for values in maps]) for name in maps[0]}

    return Tally(join_maps("sums"), join_maps("maxima"), join_maps("largest"))


def _map_values(values: Mapping[str, Array], change: Callable[[Array], Array]) -> dict[str, Array]:
    return {name: change(value) for name, value in values.items()}


Statistic = Callable[[Array], Array]


def estimates(sums: Array, counts: Array, statistic: Statistic) -> Estimate:
    """Return the jackknife's estimates of R repetitions, with their standard errors.

    Parameters
    ----------
    sums : ndarray, shape (R, G, ...)
        Sums over groups.
    counts : ndarray, shape (G,)
        Paths of each group.
    statistic : callable, ndarray of shape (..., R) -> ndarray, shape (R,)
        Function of the means.

    Returns
    -------
    Estimate
        Of arrays of shape (R,).
    """
    pseudo = pseudo_values(np.moveaxis(sums, 0, -1), counts, statistic)
    return Estimate(pseudo.mean(axis=0), pseudo.std(axis=0, ddof=1) / np.sqrt(GROUPS))


def opposite(values: Array, statistic: Statistic, sequences: int, repetitions: int) -> Array:
    """Return for each repetition the statistic of all those in the half that it is not in.

    Parameters
    ----------
    values : ndarray, shape (U, ...)
        Of repetitions in order, a whole number of them to each sequence; the function of their mean is taken.
    statistic : callable
        See `estimates`.
    sequences : int
        At least two.
    repetitions : int
        For how many the result is; of the same sequences.

    Returns
    -------
    ndarray, shape (repetitions,)
    """
    first = sequences // 2
    middle = len(values) // sequences * first
    truths = [statistic(half.mean(axis=0)) for half in (values[middle:], values[:middle])]
    own = repetitions // sequences * first
    return np.repeat(np.array(truths), [own, repetitions - own])
