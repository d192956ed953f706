"""Observer and evidence of the weak measure: the observables at T, for every level and the truth."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, lru_cache
from operator import eq, gt, lt

import numpy as np

from ..arrays import Array, Parts
from ..contracts.measure import Evidence, Snapshot
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..forms import Problem
from ..forms.truths import Moment
from ..numerics.statistics import EPS, HEAVY, Estimate, estimates, group_sums, jackknives, leave_out
from .slopes import Slopes

VALUES, SQUARES, CUBES, SIZES, KNOWN = "values ", "squares ", "cubes ", "sizes ", "truth "
# A truth with a discretisation error, and the same at half its resolution.
REFERENCE, BLURRED = "reference ", "blurred "


class MeanObserver:
    """Accumulates phi(x_l(T)) of each observable phi at all levels, and of the truth if it has the components."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem, self.settings = problem, settings
        self.wanted: Sequence[frozenset[int]] = [frozenset()] * settings.levels
        self.names = [name for name in problem.observables if self._value(name, parts) is not None]
        self.last = Snapshot([], {}, None)

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step, because expectations are compared at T."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Store the latest states."""
        self.last = snapshot

    def part(self, paths: slice) -> "MeanObserver":
        """Return the observer restricted to a subset of the paths."""
        some = copy(self)
        levels = [{name: x[..., paths] for name, x in parts.items()} for parts in self.last.levels]
        truth = {name: x[..., paths] for name, x in self.last.truth.items()}
        some.last = self.last._replace(levels=levels, truth=truth, coarser_truth=None)
        return some

    def tally(self) -> Tally:
        """Return sums over groups of paths."""
        sums: dict[str, Array] = {}
        paths = 0
        for name in self.names:
            values = np.stack([self._values(name, parts) for parts in self.last.levels])
            paths = values.shape[-1]
            sums[VALUES + name] = group_sums(values)
            sums[SQUARES + name] = group_sums(values[-1] ** 2)
            sums[CUBES + name] = group_sums(values[-1] ** 3)
            sums[SIZES + name] = group_sums(np.abs(values[-1]))
            sums |= {key + name: group_sums(known) for key, known in self._truths(name)}
        return Tally(sums={**sums, "paths": group_sums(np.ones(paths))})

    def _truths(self, name: str) -> Iterator[tuple[str, Array]]:
        if self.problem.pathwise is None:
            return
        # A reference with a discretisation error has a weak error, too, so it can only confirm a limit.
        exact, coarser = self.problem.pathwise.exact, self.last.coarser_truth or {}
        for key, parts in ((KNOWN if exact else REFERENCE, self.last.truth), (BLURRED, coarser)):
            value = self._value(name, parts)
            if value is not None:
                yield key, value

    def _values(self, name: str, parts: Parts) -> Array:
        value = self._value(name, parts)
        assert value is not None
        return value

    def _value(self, name: str, parts: Parts) -> Array | None:
        return self.problem.observe(name, self.problem.horizon, parts)


@dataclass(frozen=True)
class Means(Slopes):
    """Evidence on one observable: y = log2 |difference l|.

    Attributes
    ----------
    name : str
    h : ndarray, shape (L,)
    sums : ndarray, shape (G, L) or (G, L + 1)
        Of the observable over groups; the last column is the truth's, if it is known on every path.
    counts : ndarray, shape (G,)
    coupled : bool
        Whether there is such a column.
    squares : ndarray, shape (G,), or None
        Of the squares at the finest level.
    off_reference : (Estimate, float) or None
        |E [phi(x_L) - phi(y)]|, y a reference on these paths with a discretisation error, and |E [phi(y) - phi(z)]|,
        where z has half the resolution.
    sizes : ndarray, shape (G,), or None
        Of the absolute values at the finest level.
    cubes : ndarray, shape (G,), or None
        Of the third powers at the finest level.
    """

    name: str
    h: Array
    sums: Array
    counts: Array
    coupled: bool
    squares: Array | None = None
    off_reference: tuple[Estimate, float] | None = None
    sizes: Array | None = None
    cubes: Array | None = None

    @cached_property
    def left_out(self) -> Array:
        """Means over all paths and without each group, shape (1 + G, L) or (1 + G, L + 1)."""
        return leave_out(self.sums, self.counts)

    @cached_property
    def differences(self) -> Array:
        """Differences of these means from the truth's, or from the next level's."""
        left_out = self.left_out
        return left_out[:, :-1] - (left_out[:, -1:] if self.coupled else left_out[:, 1:])

    def find_logarithms(self) -> Array:
        """Return log2 |difference l| of all levels, including those not used in fits."""
        with np.errstate(all="ignore"):
            return np.asarray(np.log2(np.abs(self.differences)))

    @property
    def size(self) -> float:
        """E |phi| at the finest level; |E phi| if that is unknown."""
        if self.sizes is None:
            return abs(self.mean(len(self.h) - 1).value)
        return float(self.sizes.sum() / self.counts.sum())

    @property
    def skewness(self) -> float:
        """E (phi - E phi)^3 over the third power of the standard deviation, at the finest level; 0 if unknown."""
        if self.squares is None or self.cubes is None:
            return 0.0
        columns = self.sums[:, len(self.h) - 1], self.squares, self.cubes
        mean, square, cube = (float(part.sum() / self.counts.sum()) for part in columns)
        variance = square - mean**2
        third = cube - 3.0 * mean * square + 2.0 * mean**3
        return third / variance**1.5 if variance > EPS * square and np.isfinite(third) else 0.0

    @property
    def heavy(self) -> bool:
        """Whether the mean at the finest level rests on few paths: small compared with its square, in few groups."""
        if self.squares is None:
            return False
        level, groups = len(self.h) - 1, self.sums.shape[0]
        square = float(self.squares.sum() / self.counts.sum())
        # The largest group's share distinguishes a single path from a distribution about 0.
        share = float(self.squares.max() / self.squares.sum()) if square > 0.0 else 0.0
        mean = float(self.sums[:, level].sum() / self.counts.sum())
        return share > 4.0 / groups and mean**2 < HEAVY * square

    @property
    def errors(self) -> int:
        """Number of differences: errors relative to the truth, or between successive levels."""
        return len(self.h) if self.coupled else len(self.h) - 1

    def mean(self, level: int) -> Estimate:
        """Return E phi(x_l(T))."""
        return self._means[level]

    def difference(self, level: int) -> Estimate:
        """Return E [phi(x_l) - phi(x)], or E [phi(x_l) - phi(x_{l+1})], on the same paths."""
        return self._errors[level]

    @cached_property
    def _means(self) -> tuple[Estimate, ...]:
        return estimates(self.left_out)

    @cached_property
    def _errors(self) -> tuple[Estimate, ...]:
        return estimates(self.differences)

    def change(self, levels: Array) -> Estimate:
        """Return E [phi(x_l) - phi(x_k)], where l is the coarsest and k the finest level of the given differences."""
        left_out = self.left_out
        return estimates(left_out[:, levels[0]] - left_out[:, levels[-1] + 1])[0]

    def grown(self, levels: Array) -> tuple[Estimate, ...]:
        """Return the increase in size from each of the given differences to the last one."""
        sizes = np.abs(self.differences[:, levels])
        return estimates(sizes[:, -1:] - sizes[:, :-1])

    def lower_share(self, levels: Array, order: float) -> Estimate:
        """Return the share of a lower term in the error at the finest level, which is larger than in differences.

        A term a h^q leaves the last difference over 2^q - 1 as its error at the finest level.
        """
        found = super().lower_share(levels, order)
        if self.coupled or order <= 0.5:
            return found
        factor = (2.0**order - 1.0) / (2.0 ** (order - 0.5) - 1.0)
        return Estimate(factor * found.value, factor * found.se)

    def least_signal(self, levels: Array) -> float:
        """Return the smallest ratio of a difference to its standard error on the given levels."""
        found = [self.difference(level) for level in levels]
        return min(abs(x.value) / x.se if x.se > 0.0 else 0.0 for x in found)

    def one_signed(self, levels: Array) -> bool:
        """Return whether the differences have the same sign on the given levels."""
        values = [self.difference(level).value for level in levels]
        return any(all(alike(value, 0.0) for value in values) for alike in (gt, lt, eq))


def means_of(evidence: Evidence) -> Mapping[str, Means]:
    """Return the evidence on each observable that could be evaluated."""
    return evidence.along_paths.read(_means, *evidence.step_sizes)


def _means(tally: Tally, *step_sizes: float) -> dict[str, Means]:
    names = [key.removeprefix(VALUES) for key in tally.sums if key.startswith(VALUES)]
    sums, h, off = tally.sums, np.array(step_sizes), _off_references(tally, names)
    found = {}
    for name in names:
        coupled = KNOWN + name in sums
        noted = np.column_stack([sums[VALUES + name], sums[KNOWN + name]]) if coupled else sums[VALUES + name]
        further = sums.get(SQUARES + name), off.get(name), sums.get(SIZES + name), sums.get(CUBES + name)
        found[name] = Means(name, h, noted, sums["paths"], coupled, *further)
    return found


def _off_references(tally: Tally, names: Iterable[str]) -> dict[str, tuple[Estimate, float]]:
    """Return the distances of finest means from references, and of references from blurred ones, where available."""
    sums, counts = tally.sums, tally.sums["paths"]
    known = [name for name in names if REFERENCE + name in sums and BLURRED + name in sums]
    if not known:
        return {}
    both = np.stack(
        [np.column_stack([sums[VALUES + name][:, -1], sums[REFERENCE + name]]) for name in known], axis=-1
    )
    found = jackknives(both, counts, lambda means: np.abs(means[:, 0] - means[:, 1]))
    changes = (sums[REFERENCE + name] - sums[BLURRED + name] for name in known)
    moved = (abs(float(change.sum() / counts.sum())) for change in changes)
    return dict(zip(known, zip(found, moved, strict=True), strict=True))


@lru_cache
def known_mean(problem: Problem, observable: str) -> float | None:
    """Return an expectation at T from a `Moment` of the problem, or None; cached for all schemes and looks."""
    found = (t for t in problem.truths if isinstance(t, Moment) and t.observable == observable)
    return next((truth.value(problem.horizon) for truth in found), None)
