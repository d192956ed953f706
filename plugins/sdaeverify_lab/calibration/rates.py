"""Rates of events over many repetitions, compared with prescribed ranges."""

from collections.abc import Sequence
from typing import NamedTuple

from sdaeverify import Mask
from sdaeverify.numerics import clopper_pearson

# Error probability of a table; each of its n rows is tested at this level divided by n.
TABLE_LEVEL = 0.01


class ExpectedRate(NamedTuple):
    """Prescribed range of a true rate, and its description.

    Attributes
    ----------
    low, high : float
    words : str
    """

    low: float
    high: float
    words: str

    @classmethod
    def at_most(cls, rate: float, words: str = "") -> "ExpectedRate":
        """Return the range of an error rate with an upper bound."""
        return cls(0.0, rate, words or f"at most {rate:g}")


NOTHING = ExpectedRate(0.0, 1.0, "nothing promised")
COVERED = ExpectedRate(0.93, 0.97, "0.95 within 0.02")


class Rate(NamedTuple):
    """A row of the table: number of hits among independent trials.

    Attributes
    ----------
    study, case : str
    statistic : str
        Counted event.
    paths : float
        Mean sample size of a trial; NaN without sampling.
    hits, trials : int
    expected : ExpectedRate
    """

    study: str
    case: str
    statistic: str
    paths: float
    hits: int
    trials: int
    expected: ExpectedRate

    @property
    def rate(self) -> float:
        """Fraction of hits."""
        return self.hits / self.trials

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """Return the Clopper-Pearson interval of the true rate."""
        return clopper_pearson(self.hits, self.trials, confidence)

    def agrees(self, level: float) -> bool:
        """Return whether the interval of the true rate at a level intersects the prescribed range."""
        low, high = self.interval(1.0 - level)
        return low <= self.expected.high and high >= self.expected.low


class Trials(NamedTuple):
    """Common attributes of several rates; see `Rate`."""

    study: str
    case: str
    paths: float = float("nan")

    def rate(self, statistic: str, hits: Mask, expected: ExpectedRate) -> Rate:
        """Return the rate of hits among trials.

        Parameters
        ----------
        statistic : str
            Counted event.
        hits : ndarray of bool, shape (trials,)
            Whether the event occurred in each trial.
        expected : ExpectedRate
            Prescribed range.
        """
        return Rate(self.study, self.case, statistic, self.paths, int(hits.sum()), len(hits), expected)


def offending(rates: Sequence[Rate]) -> list[Rate]:
    """Return the rates outside their prescribed range.

    If all true rates lie in their range, there is any such row with a probability of at most `TABLE_LEVEL`, because
    each of the n rows with a range is tested at level `TABLE_LEVEL`/n.
    """
    promised = [rate for rate in rates if rate.expected != NOTHING]
    return [rate for rate in promised if not rate.agrees(TABLE_LEVEL / len(promised))]
