"""Pathwise errors of a component, one row a step size."""

from collections.abc import Container, Iterator, Mapping
from typing import Any

import numpy as np

from ...contracts.finding import LevelFinding
from ...numerics.statistics import Estimate
from .errors import POWERS
from .quantity import Quantity

ERROR_COLUMNS = {
    "estimate_L2": "the error in the L2 norm",
    "local_order": "order between this step size and the one before",
    "local_order_std_error": "its standard error",
    "fitted": "whether the order is fitted to this level",
}
# Of the mean relative error at T; the interval that Lindner et al. (2018), section 4.2, quote.
RELATIVE_CONFIDENCE = 0.9


def level_rows(quantity: Quantity, fitted: Container[int], norms: Mapping[str, int]) -> Iterator[LevelFinding]:
    """Yield E e_l with its standard error, and further columns.

    Parameters
    ----------
    quantity : Quantity
    fitted : container of int
        Levels that the slope was fitted on.
    norms : mapping of str to int
        Further norms (E e_l^p)^{1/p} by name, as indices of p in `POWERS`.

    Yields
    ------
    LevelFinding
    """
    means = quantity.error.sum(axis=0) / quantity.paths
    one, two = means[:, 1], means[:, 2]
    for level in range(len(means)):
        spread = np.sqrt(max(two[level] - one[level] ** 2, 0.0) / quantity.paths)
        local: Any = Estimate(float("nan"), float("nan"))
        if level and one[level - 1 : level + 1].all():
            local = quantity.slope(np.array([level - 1, level]))
        details = {
            **{f"estimate_{name}": means[level, index] ** (1.0 / POWERS[index]) for name, index in norms.items()},
            "local_order": local.value,
            "local_order_std_error": local.se,
            "fitted": level in fitted,
            **_relative(quantity, level),
        }
        yield LevelFinding(quantity.name, level, float(one[level]), float(spread), details)


def _relative(quantity: Quantity, level: int) -> dict[str, float]:
    """Return the mean over paths of |x_l - x|/|x| at T, with its interval."""
    if quantity.relative is None:
        return {}
    mean = quantity.relative_error(level)
    low, high = mean.interval(RELATIVE_CONFIDENCE)
    return {"relative": mean.value, "relative_low": low, "relative_high": high}
