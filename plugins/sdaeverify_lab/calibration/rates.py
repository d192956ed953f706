"""How often something happened over many repetitions, and whether that agrees with what is promised."""

from collections.abc import Sequence
from typing import NamedTuple

from sdaeverify import Mask
from sdaeverify.numerics import clopper_pearson

# Error probability of one table: agreement is tested row by row at this level over the number of rows.
TABLE_LEVEL = 0.01


class ExpectedRate(NamedTuple):
    """The range a true rate is promised to be in, and why.

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
        """Return the promise of an error rate."""
        return cls(0.0, rate, words or f"at most {rate:g}")


NOTHING = ExpectedRate(0.0, 1.0, "nothing promised")
COVERED = ExpectedRate(0.93, 0.97, "0.95 within 0.02")


class Rate(NamedTuple):
    """A row of the table: hits among independent trials.

    Attributes
    ----------
    study, case : str
    statistic : str
        What is counted.
    paths : float
        Sample size of one trial, on average; NaN where there is none.
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
        """Share of the hits."""
        return self.hits / self.trials

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """Return the interval of Clopper and Pearson for the true rate."""
        return clopper_pearson(self.hits, self.trials, confidence)

    def agrees(self, level: float) -> bool:
        """Tell whether the true rate may be in the promised range: the two intervals meet."""
        low, high = self.interval(1.0 - level)
        return low <= self.expected.high and high >= self.expected.low


class Trials(NamedTuple):
    """What some rates have in common; see `Rate` for the attributes."""

    study: str
    case: str
    paths: float = float("nan")

    def rate(self, statistic: str, hits: Mask, expected: ExpectedRate) -> Rate:
        """Return the rate at which some trials hit.

        Parameters
        ----------
        statistic : str
            What is counted.
        hits : ndarray of bool, shape (trials,)
            In which of the trials it happened.
        expected : ExpectedRate
            Range of rates that is promised.
        """
        return Rate(self.study, self.case, statistic, self.paths, int(hits.sum()), len(hits), expected)


def offending(rates: Sequence[Rate]) -> list[Rate]:
    """Return the rows that disagree with their promise.

    Where all promises are kept there is any such row with a probability of at most `TABLE_LEVEL`: each of the n rows
    with a promise is tested at level `TABLE_LEVEL`/n.
    """
    promised = [rate for rate in rates if rate.expected != NOTHING]
    return [rate for rate in promised if not rate.agrees(TABLE_LEVEL / len(promised))]
