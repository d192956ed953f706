"""Observer of the strong measure: pathwise errors at T and as maximum over the coarsest grid."""

from collections.abc import Mapping, Sequence
from copy import copy
from itertools import pairwise

import numpy as np

from ...arrays import Array, Parts
from ...contracts.measure import Snapshot
from ...contracts.scheme import AT_T
from ...contracts.settings import Settings
from ...contracts.tally import EXTREMES, Tally, largest
from ...numerics.digits import SAMPLED, TAIL, significant
from ...numerics.statistics import group_sums

# Size: norms that are accumulated.
POWERS = np.array([0.5, 1.0, 2.0, 4.0])
# The last one is accumulated only on request.
# Size: the first three norms.
COMMON = 3
STATE = "state"
# Name of errors in the evidence.
ERROR = "error"


class ErrorObserver:
    """Accumulates errors and successive differences of each component c and of the full state.

    e_l = |x_l - x| and d_l = |x_l - x_{l+1}| (levels l, truth x); the distance of x from its start; if the truth has
    a discretisation error, also the blurred errors relative to the truth at half resolution. At T, the relative error
    |x_l - x|/|x| of each path as well: for nodes z_i of equal weight ds it equals that of (sum_i |z_i|^2 ds)^{1/2},
    because ds cancels. Its mean is infinite if x comes near 0 too often.

    Parameters
    ----------
    parts : mapping of str to ndarray, shape (n, P)
        Initial components.
    settings : Settings
    powers : int, optional
        Number of `POWERS` that are accumulated.
    """

    def __init__(self, parts: Parts, settings: Settings, powers: int = COMMON) -> None:
        self.settings, self.powers = settings, powers
        self.wanted: Sequence[frozenset[int]] = [frozenset()] * settings.levels
        self.start = parts
        self.names: list[str] = []
        self.size: dict[str, Array] = {}
        self.moved: dict[str, Array] = {}
        self.final: dict[str, Array] = {}
        self.worst: dict[str, Array] = {}
        self.length = np.zeros(0)

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step, because errors are compared on the coarsest grid."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Compute the errors at this time and update their maximum."""
        self.names = [name for name in self.start if name in snapshot.truth]
        levels = snapshot.levels
        now = {
            ERROR: [self._distances(level, snapshot.truth) for level in levels],
            "difference": [self._distances(a, b) for a, b in pairwise(levels)],
            "motion": [self._distances(snapshot.truth, self.start)],
        }
        if snapshot.coarser_truth is not None:
            now["blurred"] = [self._distances(level, snapshot.coarser_truth) for level in levels]
        self.final = {name: np.stack(values, axis=1) for name, values in now.items()}
        self.worst = {name: np.maximum(self.worst.get(name, 0.0), value) for name, value in self.final.items()}
        self.length = _norms([snapshot.truth[name] for name in self.names])
        self._note_sizes(snapshot.truth)

    def part(self, paths: slice) -> "ErrorObserver":
        """Return the observer restricted to a subset of the paths."""
        some = copy(self)
        some.final = {kind: value[..., paths] for kind, value in self.final.items()}
        some.worst = {kind: value[..., paths] for kind, value in self.worst.items()}
        some.length = self.length[..., paths]
        return some

    def tally(self, *, at_end: bool = True) -> Tally:
        """Return sums of the errors' powers and of the other distances over groups of paths, and the largest errors.

        Of the maxima over the grid and, with `at_end`, of the errors at T.
        """
        sums: dict[str, Array] = {}
        tops: dict[str, Array] = {}
        for index, name in enumerate(self._quantities()):
            for suffix, values in (("", self.worst), (AT_T, self.final))[: 1 + at_end]:
                for kind, value in values.items():
                    key = f"{kind} {name}{suffix}"
                    sums[key] = power_sums(value[index], self.powers) if kind == ERROR else _sums(value[index])
                tops[f"{name}{suffix}"] = largest_errors(values[ERROR][index])
            if at_end:
                sums[f"relative {name}{AT_T}"] = self._relative(index)
        paths = self.final[ERROR].shape[-1]
        sums["paths"] = group_sums(np.ones(paths))
        return Tally(sums=sums, maxima={**self.size, **self.moved}, largest=tops)

    def _note_sizes(self, truth: Parts) -> None:
        for name in self.names:
            known = truth[name]
            for kind, noted, value in (("size", self.size, known), ("moved", self.moved, known - self.start[name])):
                largest_now = np.atleast_1d(np.fmax.reduce(np.abs(value), axis=None))
                for quantity in {name, STATE}:
                    key = f"{kind} {quantity}"
                    noted[key] = np.fmax(noted.get(key, 0.0), largest_now)

    def _relative(self, index: int) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            return _sums(self.final[ERROR][index] / self.length[index])

    def _quantities(self) -> list[str]:
        return self.names if len(self.names) == 1 else [*self.names, STATE]

    def _distances(self, a: Parts, b: Parts) -> Array:
        return _norms([a[name] - b[name] for name in self.names])


def power_sums(values: Array, powers: int) -> Array:
    """Return the sums of e^p over groups for the first of `POWERS`, shape (G, L, powers), from errors (L, P)."""
    squares = values * values
    raised = [np.sqrt(values), values, squares, *([squares * squares] if powers > COMMON else [])]
    return np.moveaxis(_sums(np.stack(raised)), 1, -1)


def largest_errors(values: Array) -> Array:
    """Return the largest errors of each level, descending."""
    return significant(largest(values, EXTREMES), TAIL)


def tally_errors(kind: str, errors: Mapping[str, Array]) -> Tally:
    """Return the sums of all `POWERS` of errors over groups of paths, and the largest errors.

    Parameters
    ----------
    kind : str
        Name of the errors in the evidence, see `quantities_of`.
    errors : mapping of str to ndarray, shape (L, P)
        Of each component.
    """
    return Tally(
        sums={f"{kind} {name}": power_sums(value, len(POWERS)) for name, value in errors.items()},
        largest={f"{kind} {name}": largest_errors(value) for name, value in errors.items()},
    )


def _sums(values: Array) -> Array:
    return significant(group_sums(values), SAMPLED)


def _norms(components: Sequence[Array]) -> Array:
    """Return the norm of each component and, if there are several, of all of them together, shape (Q, P)."""
    squares = [(component**2).sum(axis=0) for component in components]
    if len(squares) > 1:
        squares.append(sum(squares[1:], squares[0]))
    roots: Array = np.sqrt(np.stack(squares))
    return roots
