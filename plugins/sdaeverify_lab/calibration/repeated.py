"""Many repetitions of a measurement in one block: tallies of consecutive subsets of its paths.

A repetition of UNIT paths is the smallest sample; adjacent repetitions are pooled into larger samples. Stacked
tallies are tallies whose arrays have the repetition as first axis. Statistics are computed for many repetitions at
once, and true values from independent repetitions.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from sdaeverify import Array, Parts, Problem, Settings
from sdaeverify.measuring import Estimate, Measure, Observer, Snapshot, Tally
from sdaeverify.numerics import GROUPS, pseudo_values

UNIT = 100
# Number of repetitions in the largest sample.
POOLED = 16


class Divisible(Observer, Protocol):
    """An observer that can return the observer of a subset of its paths."""

    def part(self, paths: slice) -> Observer:
        """Return the observer of a subset of the paths."""
        ...


@dataclass(frozen=True)
class Repeated(Measure):
    """A measure that applies another measure to each repetition separately.

    Attributes
    ----------
    measure : Measure
        Measure whose observers are `Divisible`.
    """

    measure: Any

    name: ClassVar[str] = "repeated"

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> "RepeatedObserver":
        """Return the observer for one block."""
        # Settings that depend on the sample size are those of the largest sample, not of the whole block.
        return RepeatedObserver(self.measure.observer(problem, parts, replace(settings, paths=UNIT * POOLED)))


class RepeatedObserver:
    """Forward all calls to an observer, and split its tally into repetitions at the end."""

    def __init__(self, inner: Divisible) -> None:
        self.inner, self.wanted, self.paths = inner, inner.wanted, 0

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Forward the step."""
        self.inner.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Forward the states, and store the number of paths."""
        self.paths = max(part.shape[-1] for part in snapshot.levels[0].values())
        self.inner.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the stacked tallies of all complete repetitions."""
        starts = range(0, self.paths - UNIT + 1, UNIT)
        return stack_tallies([self.inner.part(slice(start, start + UNIT)).tally() for start in starts])


def stack_tallies(tallies: Sequence[Tally]) -> Tally:
    """Stack the tallies of several repetitions."""
    return _join(tallies, np.stack)


def append_tallies(tallies: Sequence[Tally]) -> Tally:
    """Concatenate several stacked tallies."""
    return _join(tallies, np.concatenate)


def pool(tally: Tally, count: int, every: int | None = None) -> Tally:
    """Pool the first `count` of each group of `every` adjacent repetitions; `every` defaults to `count`.

    Parameters
    ----------
    tally : Tally
        Stacked tally.
    count : int
        Number of repetitions in a pooled sample.
    every : int, optional
        Distance between the first repetitions of two samples; if larger than `count`, the others are unused.
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
    """Return the jackknife estimates of R repetitions, with standard errors.

    Parameters
    ----------
    sums : ndarray, shape (R, G, ...)
        Sums over groups.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    statistic : callable, ndarray of shape (..., R) -> ndarray, shape (R,)
        Function of the means.

    Returns
    -------
    Estimate
        Estimate whose fields have the shape (R,).
    """
    pseudo = pseudo_values(np.moveaxis(sums, 0, -1), counts, statistic)
    return Estimate(pseudo.mean(axis=0), pseudo.std(axis=0, ddof=1) / np.sqrt(GROUPS))


def opposite(values: Array, statistic: Statistic, sequences: int, repetitions: int) -> Array:
    """Return for each repetition the statistic of all repetitions in the other half.

    Parameters
    ----------
    values : ndarray, shape (U, ...)
        Values of repetitions in order, with an equal number for each sequence; the statistic is taken of their mean.
    statistic : callable
        See `estimates`.
    sequences : int
        Number of sequences, at least two.
    repetitions : int
        Number of repetitions in the result, of the same sequences.

    Returns
    -------
    ndarray, shape (repetitions,)
    """
    first = sequences // 2
    middle = len(values) // sequences * first
    truths = [statistic(half.mean(axis=0)) for half in (values[middle:], values[:middle])]
    own = repetitions // sequences * first
    return np.repeat(np.array(truths), [own, repetitions - own])
