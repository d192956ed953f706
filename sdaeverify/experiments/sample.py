"""Mean and variance of a sample that grows block by block, without cancellation."""

from math import nan, sqrt
from typing import NamedTuple

from ..arrays import Array


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
    """

    paths: int = 0
    mean: float = 0.0
    squares: float = 0.0
    without_root: int = 0
    lost: int = 0
    error: str = ""

    @classmethod
    def of(cls, values: Array, without_root: int = 0, lost: int = 0) -> "Sample":
        """Return the sample of some values, shape (P,)."""
        mean = float(values.mean())
        return cls(len(values), mean, float(((values - mean) ** 2).sum()), without_root, lost)

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
            paths, self.mean + d * share, squares, self.without_root + other.without_root, self.lost + other.lost
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
