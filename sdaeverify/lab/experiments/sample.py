"""Mean and variance of a sample that grows block by block, without cancellation."""

from math import isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...numerics.statistics import group_sums

Group = tuple[float, float]


class Sample(NamedTuple):
    """What is known of an observable on some paths.

    Attributes
    ----------
    paths : int
    mean : float
    squares : float
        Sum of (y_i - mean)^2.
    without_root, lost : int
        Paths on which a step found no root; and which are not finite or blew up, so that there is no mean.
    error : str
        Why there is no sample; empty if there is one.
    groups : tuple of (float, float)
        Paths and sum of y_i of the groups that a jackknife leaves out; empty without paths.
    """

    paths: int = 0
    mean: float = 0.0
    squares: float = 0.0
    without_root: int = 0
    lost: int = 0
    error: str = ""
    groups: tuple[Group, ...] = ()

    @classmethod
    def of(cls, values: Array, without_root: int = 0, lost: int = 0) -> "Sample":
        """Return the sample of some values, shape (P,)."""
        mean = float(values.mean())
        groups = tuple(
            (paths, total) for paths, total in group_sums(np.stack([np.ones_like(values), values])).tolist()
        )
        squares = float(((values - mean) ** 2).sum())
        return cls(len(values), mean, squares, without_root, lost, groups=groups)

    def merged(self, other: "Sample") -> "Sample":
        """Return the sample of both.

        With d the difference of the means, squares = squares_1 + squares_2 + d^2 n_1 n_2/(n_1 + n_2).
        """
        if self.error or other.error:
            return Sample(error=self.error or other.error)
        paths = self.paths + other.paths
        if not paths:
            return self
        share, d = other.paths / paths, other.mean - self.mean
        squares = self.squares + other.squares + d**2 * self.paths * share
        return Sample(
            paths,
            self.mean + d * share,
            squares,
            self.without_root + other.without_root,
            self.lost + other.lost,
            groups=_joined(self.groups, other.groups),
        )

    @property
    def value(self) -> float:
        """The mean; NaN without paths, or if one of them is lost."""
        return self.mean if self.paths and not self.lost else nan

    @property
    def deviation(self) -> float:
        """Standard deviation of a path; NaN as the mean, or for one path."""
        return sqrt(self.squares / (self.paths - 1)) if self.paths > 1 and not self.lost else nan

    @property
    def std_error(self) -> float:
        """Standard error of the mean."""
        return self.deviation / sqrt(self.paths) if self.paths else nan

    @property
    def effective(self) -> float:
        """(sum y)^2/sum y^2, the number of equal y_i >= 0 whose mean would be known as well."""
        squares = self.squares + self.paths * self.mean**2
        return (self.paths * self.mean) ** 2 / squares if squares > 0.0 and isfinite(self.value) else nan


def _joined(groups: tuple[Group, ...], others: tuple[Group, ...]) -> tuple[Group, ...]:
    if not (groups and others):
        return groups or others
    return tuple((a + c, b + d) for (a, b), (c, d) in zip(groups, others, strict=True))
