"""By which factor the errors of a quantity have grown: a paired estimate on common noise.

With the mean errors e_l of the old run and e'_l of the new one at the finest step sizes that both could tell,

    log2 F = mean_l log2(e'_l/e_l),

and the order has changed by the slope of log2(e'_l/e_l) against log2 h_l.

Both runs leave the same groups of paths out of the jackknife. What their errors have in common, which is nearly all
that is random in them where a scheme has changed little, cancels in the ratio.
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...numerics.statistics import Estimate, estimates, slope_weights
from ...verdicts.fitted_levels import FITTED
from ...verdicts.path_tests import CALIBRATED_PATHS
from .level_errors import LevelErrors

WAS_EXACT, IS_EXACT, ORDER_ALONE = "it was exact", "it is exact now", "its order alone is known"
UNTOLD = "no step size at which both errors can be told"
# Step sizes of two runs are the same up to rounding.
SAME = 1e-9
# An error of less than 2 to this part of the other one is rounding.
ROUNDING = -20.0


class Factor(NamedTuple):
    """New error over old error.

    Attributes
    ----------
    log2 : Estimate
        Of its logarithm; without standard error where nothing is sampled, 0 where the order alone is known.
    levels : int
        Step sizes it is the mean of.
    sampled : bool
    reason : str
        Why there is none, or what is special about it.
    order : Estimate
        New order minus old order; NaN where fewer than two step sizes are common.
    """

    log2: Estimate
    levels: int = 0
    sampled: bool = False
    reason: str = ""
    order: Estimate = Estimate(nan, nan)

    @property
    def known(self) -> bool:
        """Whether there is one."""
        return not np.isnan(self.log2.value)

    @property
    def is_order_alone(self) -> bool:
        """Whether no error is told in both runs, and only the order is known of each."""
        return not self.levels and not np.isnan(self.order.value)


def factor(old: LevelErrors, new: LevelErrors) -> Factor:
    """Return by which factor errors have grown from one run to another.

    Parameters
    ----------
    old, new : LevelErrors
        Of one quantity, on the same noise.

    Returns
    -------
    Factor
        Infinite where errors were rounding and are not now, 0 the other way round.
    """
    if obstacle := _obstacle(old, new):
        return no_factor(obstacle)
    mine, others = _common(old, new)
    with np.errstate(invalid="ignore"):  # Both may be 0.
        moved = new.log2[:, others] - old.log2[:, mine]
    told = (old.told[mine] & new.told[others] & np.isfinite(moved).all(axis=0)).nonzero()[0][-FITTED:]
    if not len(told):
        return _without_common_levels(old, new, moved[0, old.told[mine] | new.told[others]])
    mean = np.full(len(told), 1.0 / len(told))
    slope = slope_weights(np.log2(old.h[mine[told]])) if len(told) > 1 else np.full(1, nan)
    size, order = (_estimate(moved[:, told] @ weights) for weights in (mean, slope))
    return Factor(size, len(told), sampled=old.counts is not None, order=order)


def _estimate(values: Array) -> Estimate:
    return estimates(values)[0] if len(values) > 1 else Estimate(float(values[0]), 0.0)


def _without_common_levels(old: LevelErrors, new: LevelErrors, moved: Array) -> Factor:
    """Return what is known where no error is told in both runs: one of them may be rounding, or orders are known.

    Parameters
    ----------
    old, new : LevelErrors
    moved : ndarray
        Logarithms of the ratios of errors of which one is told.
    """
    for sign, reason in ((1.0, WAS_EXACT), (-1.0, IS_EXACT)):
        if len(moved) and (sign * moved > -ROUNDING).all():
            return Factor(Estimate(sign * inf, 0.0), reason=reason)
    order = new.order - old.order
    if np.isfinite(order):
        return Factor(Estimate(0.0, 0.0), reason=ORDER_ALONE, order=Estimate(order, 0.0))
    return no_factor(UNTOLD)


def _obstacle(old: LevelErrors, new: LevelErrors) -> str:
    if (old.counts is None) != (new.counts is None):
        return "sampled in one run only"
    if old.counts is None or new.counts is None:
        return ""
    if not np.array_equal(old.counts, new.counts):
        return f"{old.counts.sum():.0f} paths in one run, {new.counts.sum():.0f} in the other"
    if old.counts.sum() < CALIBRATED_PATHS:
        return f"{old.counts.sum():.0f} common paths, intervals are calibrated from {CALIBRATED_PATHS} on"
    return ""


def _common(old: LevelErrors, new: LevelErrors) -> tuple[Array, Array]:
    """Return the places of the step sizes that both have, in either."""
    mine, others = np.nonzero(np.isclose(old.h[:, np.newaxis], new.h, rtol=SAME, atol=0.0))
    return mine, others


def no_factor(reason: str) -> Factor:
    """Return that there is none, and why."""
    return Factor(Estimate(nan, nan), reason=reason)
