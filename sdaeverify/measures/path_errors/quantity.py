"""The evidence on one component's pathwise errors, and the statistics that are taken from it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import inf

import numpy as np

from ...arrays import Array
from ...contracts.measure import Evidence
from ...numerics.statistics import EPS, Estimate, Tail, jackknife, log_functional, order_of, slope_weights, tail
from .errors import AT_T, POWERS


@dataclass(frozen=True)
class Quantity:
    """The evidence on one component.

    Attributes
    ----------
    name : str
    h : ndarray, shape (L,)
        Step sizes.
    error : ndarray, shape (G, L, 3) or (G, L, 4)
        Sums of e_l^p over groups, p = 1/2, 1, 2 and perhaps 4.
    difference : ndarray, shape (G, L - 1, 3) or (G, L - 1, 4)
        The same of |x_l - x_{l+1}|.
    blurred : ndarray, shape (G, L, 3) or (G, L, 4), or None
        The same as `error` against the truth at half its resolution, where it has an error of its own.
    relative : ndarray, shape (G, L), or None
        Sums of |x_l - x|/|x| over groups, at T.
    counts : ndarray, shape (G,)
    largest : ndarray, shape (L, k)
    size, moved : float
        Largest value of the true component, and how far it has moved from its initial value.
    motion : float
        The mean over paths of the latter; infinite where it was not noted.
    """

    name: str
    h: Array
    error: Array
    difference: Array
    blurred: Array | None
    relative: Array | None
    counts: Array
    largest: Array
    size: float
    moved: float
    motion: float = inf

    @property
    def paths(self) -> int:
        """Number of paths."""
        return int(self.counts.sum())

    def rounding(self, steps: Array) -> Array:
        """Return eps sqrt(N) times the component's size: what rounding accumulates to over N steps."""
        return np.asarray(EPS * self.size * np.sqrt(steps))

    def means(self, power: int = 1) -> Array:
        """Return E e_l^p, shape (L,)."""
        return np.asarray(self.error[..., power].sum(axis=0) / self.paths)

    def slope(self, levels: Array, power: int = 1) -> Estimate:
        """Return the least-squares slope of log2 (E e^p)^(1/p) against log2 h on some levels."""
        return order_of(self.h[levels], self.error[:, levels, power], self.counts, POWERS[power])

    def linear(self, levels: Array, weights: Array, power: int = 1) -> Estimate:
        """Return a linear functional of y on some levels.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape (levels,)
            Of y = log2 (E e^p)^(1/p) on them.
        power : int
            Place of p among `POWERS`.
        """
        return jackknife(self.error[:, levels, power], self.counts, partial(log_functional, weights, POWERS[power]))

    def contrast(self, levels: Array, share: float = 1.0) -> Estimate:
        """Return slope of log2 E e_{l+1} minus slope of log2 E d_l over the same levels l: 0 in the right limit.

        Or minus a share of the latter.
        """
        coarse, fine = levels[:-1], levels[1:]
        weights = slope_weights(np.log2(self.h[coarse]))
        both = np.concatenate([self.error[:, fine, 1], self.difference[:, coarse, 1]], axis=1)
        return jackknife(both, self.counts, partial(log_functional, np.concatenate([weights, -share * weights]), 1.0))

    def rise(self, levels: Array) -> Estimate:
        """Return by how much the local order grows from the last but one pair of levels to the last."""
        return self.linear(levels[-3:], np.array([-1.0, 2.0, -1.0]))

    def ahead(self, levels: Array) -> Estimate:
        """Return the local order at the next step size, if it grows by as much as it did between the last two."""
        return self.linear(levels[-3:], np.array([-1.0, 3.0, -2.0]))

    def blur(self, levels: Array) -> Estimate:
        """Return by how much the slope changes if the truth is taken at half its resolution."""
        assert self.blurred is not None
        weights = slope_weights(np.log2(self.h[levels]))
        both = np.concatenate([self.error[:, levels, 1], self.blurred[:, levels, 1]], axis=1)
        return jackknife(both, self.counts, partial(log_functional, np.concatenate([-weights, weights]), 1.0))

    def relative_error(self, level: int) -> Estimate:
        """Return E |x_l - x|/|x| at T."""
        assert self.relative is not None
        return jackknife(self.relative[:, level], self.counts, float)

    def tail(self, level: int) -> Tail:
        """Return the tail diagnostics of a level."""
        sums = self.error[:, level].sum(axis=0)
        return tail(float(sums[1]), float(sums[2]), self.largest[level], self.paths)


def quantities_of(evidence: Evidence) -> Iterator[Quantity]:
    """Yield the quantities of a cell in the order in which they were noted."""
    sums, h = evidence.tally.sums, np.array(evidence.step_sizes)
    names = [name.removeprefix("error ") for name in sums if name.startswith("error ")]
    for name in names:
        component = name.removesuffix(AT_T)
        yield Quantity(
            name=name,
            h=h,
            error=sums[f"error {name}"],
            difference=sums[f"difference {name}"],
            blurred=sums.get(f"blurred {name}"),
            relative=sums.get(f"relative {name}"),
            counts=sums["paths"],
            largest=evidence.tally.largest[name][..., : evidence.settings.extremes],
            size=float(evidence.tally.maxima[f"size {component}"][0]),
            moved=float(evidence.tally.maxima[f"moved {component}"][0]),
            motion=_mean(sums.get(f"motion {name}"), sums["paths"]),
        )


def _mean(sums: Array | None, counts: Array) -> float:
    return inf if sums is None else float(sums[:, 0, 1].sum() / counts.sum())
