"""Orders of a step that is not a B-series with fixed weights, from the rates at which its defects vanish.

If the defect of each tree on paths has size h^q, and that of the mean of each forest size h^r, then

    strong order  min(q - 1/2, r - 1) over trees,    weak order  min(r - 1) over forests,

up to the largest examined weight. A step may be wrong beyond it, so that these orders do not verify a claim.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from .conditions import STRONG, Condition

# Step sizes, and the bound for rounding in a component of the step.
SIZES = (2.0**-8, 2.0**-12, 2.0**-16)
ROUNDING = 1e-13


class Rate(NamedTuple):
    """Rate at which the defect of a condition vanishes.

    Attributes
    ----------
    condition : Condition
        Condition with the defect at the finest step size.
    power : float
        Power of h of the defect; infinite if no defect exceeds rounding.
    """

    condition: Condition
    power: float

    def order(self, measure: str) -> float:
        """Return the order that the defect permits; infinite if the measure does not depend on the condition."""
        condition = self.condition
        if measure != STRONG and condition.on_paths:
            return np.inf
        left = self.power + 0.5 * condition.spent - (0.5 if condition.on_paths else 1.0)
        return left if measure != STRONG or len(condition.forest) == 1 else np.inf


def rates(found: Sequence[Sequence[Condition]]) -> Iterator[Rate]:
    """Yield the rates of the defects of conditions, at the finest pair of step sizes with a defect above rounding.

    Parameters
    ----------
    found : sequence of sequence of Condition
        The same conditions at each of `SIZES`, with defects in units of h^(w/2).
    """
    for same in zip(*found, strict=True):
        sizes = np.array([each.defect * h ** (0.5 * each.weight) for each, h in zip(same, SIZES, strict=True)])
        seen = [place for place in range(1, len(SIZES)) if sizes[place] > ROUNDING]
        if not seen:
            yield Rate(same[-1], np.inf)
            continue
        at = seen[-1]
        yield Rate(same[-1], float(np.log(sizes[at - 1] / sizes[at]) / np.log(SIZES[at - 1] / SIZES[at])))


def slowest(found: Sequence[Rate], measure: str) -> Rate:
    """Return the rate that permits the least order of a measure.

    Parameters
    ----------
    found : sequence of Rate
    measure : str
    """
    return min(found, key=lambda rate: rate.order(measure))


def order_left(found: Sequence[Rate], measure: str, top: int) -> float:
    """Return the order that the defects of trees up to a weight permit.

    Parameters
    ----------
    found : sequence of Rate
    measure : str
    top : int
        Largest weight.
    """
    return max(0.0, min(0.5 * (top - 1), slowest(found, measure).order(measure)))


def largest_change(first: Array, other: Array, rounding: Array | float = 0.0) -> float:
    """Return the largest relative difference of weights between step sizes beyond rounding.

    Parameters
    ----------
    first, other : ndarray, shape (N, n)
        Weights at two step sizes.
    rounding : ndarray, shape (N, 1), or float
        Rounding errors of `other`.
    """
    off = np.maximum(np.abs(other - first) - rounding, 0.0)
    return float(np.max(off / (1.0 + np.abs(first)), initial=0.0))
