"""What a factor says: errors are the same, worse, better, or it cannot be told."""

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from ...errors import UsageError
from ...study.holm import holm
from .factors import Factor


class Change(StrEnum):
    """What became of the errors of a quantity."""

    SAME = "same"
    WORSE = "worse"
    BETTER = "better"
    UNDECIDED = "undecided"


class Changed(NamedTuple):
    """A factor with its interval, and what it says.

    Attributes
    ----------
    factor, low, high : float
        New error over old error, with an interval of level 1 - alpha, alike where nothing is sampled.
    change : Change
    """

    factor: float
    low: float
    high: float
    change: Change


def changes(factors: Sequence[Factor], margin: float = 1.1, alpha: float = 0.01) -> list[Changed]:
    """Return what factors say, the errors of all tests together being bounded.

    Worse is what is significantly larger than the margin, better what is significantly smaller than its inverse: by
    Holm's procedure, the probability that any of them is wrong is at most alpha for either. The same is what has all
    of its interval between the two. Where nothing is sampled the factor itself is compared.

    Parameters
    ----------
    factors : sequence of Factor
        Known ones.
    margin : float, optional
        Above 1.
    alpha : float, optional

    Raises
    ------
    UsageError
        If the margin or alpha is out of its range.
    """
    if not 1.0 < margin < float("inf"):
        raise UsageError(f"the factor must be above 1, got {margin}")
    if not 0.0 < alpha <= 0.5:
        raise UsageError(f"alpha must be above 0 and at most 0.5, got {alpha}")
    bound = float(np.log2(margin))
    tested = {(i, 0): each.log2 for i, each in enumerate(factors) if each.sampled}
    worse = holm({place: log2.p_above(bound) for place, log2 in tested.items()}, alpha)
    better = holm({place: log2.p_below(-bound) for place, log2 in tested.items()}, alpha)
    signs = [((i, 0) in worse) - ((i, 0) in better) for i in range(len(factors))]
    return [_changed(each, bound, alpha, sign) for each, sign in zip(factors, signs, strict=True)]


def _changed(found: Factor, bound: float, alpha: float, significant: int) -> Changed:
    value = found.log2.value
    low, high = found.log2.interval(1.0 - alpha) if found.sampled else (value, value)
    if not found.sampled:
        significant = int(value > bound) - int(value < -bound)
    change = Change.SAME if -bound <= low and high <= bound else Change.UNDECIDED
    if significant:
        change = Change.WORSE if significant > 0 else Change.BETTER
    return Changed(float(np.exp2(value)), float(np.exp2(low)), float(np.exp2(high)), change)
