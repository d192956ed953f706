"""Mean and variance of a sample."""

from math import isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.measuring import group_sums


class MeanSample(NamedTuple):
    """Sample of an observable on some paths.

    Attributes
    ----------
    paths : int
    mean : float
    squares : float
        Sum of (y_i - mean)^2.
    without_root, lost : int
        Numbers of paths on which a step found no root, and that are not finite or blew up; the latter leave no mean.
    error : str
        Why there is no sample; empty if there is one.
    groups : tuple of (float, float)
        Number of paths and sum of y_i of the groups of the jackknife; empty without paths.
    """

    paths: int = 0
    mean: float = 0.0
    squares: float = 0.0
    without_root: int = 0
    lost: int = 0
    error: str = ""
    groups: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, values: Array, without_root: int = 0, lost: int = 0) -> "MeanSample":
        """Create the sample from values, shape (P,).

        Parameters
        ----------
        values : ndarray, shape (P,)
            Values on the paths.
        without_root, lost : int
            Numbers of paths with a step without root, and of paths that are not finite.
        """
        if not len(values):
            return cls()
        mean = float(values.mean())
        groups = tuple(
            (paths, total) for paths, total in group_sums(np.stack([np.ones_like(values), values])).tolist()
        )
        squares = float(((values - mean) ** 2).sum())
        return cls(len(values), mean, squares, without_root, lost, groups=groups)

    @property
    def value(self) -> float:
        """Mean; NaN without paths, or if a path is lost."""
        return self.mean if self.paths and not self.lost else nan

    @property
    def deviation(self) -> float:
        """Standard deviation of a path; NaN as for the mean, or for a single path."""
        return sqrt(self.squares / (self.paths - 1)) if self.paths > 1 and not self.lost else nan

    @property
    def std_error(self) -> float:
        """Standard error of the mean."""
        return self.deviation / sqrt(self.paths) if self.paths else nan

    @property
    def effective(self) -> float:
        """Effective sample size (sum y)^2/sum y^2 for y_i >= 0."""
        squares = self.squares + self.paths * self.mean**2
        return (self.paths * self.mean) ** 2 / squares if squares > 0.0 and isfinite(self.value) else nan
