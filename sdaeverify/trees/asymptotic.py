"""Orders of a step that is no B-series of fixed weights: how fast its defects vanish as h tends to 0.

With the defect of each tree path by path, of size h^q, and of the mean of each forest, of size h^r,

    strong order  min(q - 1/2, r - 1) over trees,    weak order  min(r - 1) over forests,

as far as the trees go that are looked at: a step may be wrong beyond them, so that this verifies nothing.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .conditions import STRONG, Condition

# Step sizes, and what is rounding in a component of the step.
SIZES = (2.0**-8, 2.0**-12, 2.0**-16)
ROUNDING = 1e-13


class Rate(NamedTuple):
    """How fast the defect of a condition vanishes.

    Attributes
    ----------
    condition : Condition
        As it was found with the finer steps.
    power : float
        Of h; infinite where there is no defect beyond rounding.
    """

    condition: Condition
    power: float

    def order(self, measure: str) -> float:
        """Return the order that the defect leaves to a measure; infinite if it does not concern it."""
        condition = self.condition
        if measure != STRONG and condition.on_paths:
            return np.inf
        left = self.power + 0.5 * condition.spent - (0.5 if condition.on_paths else 1.0)
        return left if measure != STRONG or len(condition.forest) == 1 else np.inf


def rates(found: Sequence[Sequence[Condition]]) -> Iterator[Rate]:
    """Yield the rates of the defects of conditions between the finest step sizes at which they are above rounding.

    Parameters
    ----------
    found : sequence of sequence of Condition
        The same ones at each of `SIZES`, in units of h^(w/2).
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
    """Return the rate that leaves the least order to a measure.

    Parameters
    ----------
    found : sequence of Rate
    measure : str
    """
    return min(found, key=lambda rate: rate.order(measure))


def order_left(found: Sequence[Rate], measure: str, top: int) -> float:
    """Return the order that defects leave, as far as trees up to a weight tell.

    Parameters
    ----------
    found : sequence of Rate
    measure : str
    top : int
        The largest weight.
    """
    return max(0.0, min(0.5 * (top - 1), slowest(found, measure).order(measure)))


def largest_change(first: Array, other: Array) -> float:
    """Return how far weights differ between step sizes, relative to them."""
    return float(np.max(np.abs(other - first) / (1.0 + np.abs(first)), initial=0.0))
