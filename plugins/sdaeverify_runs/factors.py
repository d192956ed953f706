"""Factor by which the errors of a quantity have grown: a paired estimate on common noise.

With the mean errors e_l of the old run and e'_l of the new one at the finest step sizes at which both are
significant,

    log2 F = mean_l log2(e'_l/e_l),

and the order has changed by the slope of log2(e'_l/e_l) against log2 h_l.

The jackknife leaves the same groups of paths out of both runs. The common random part of the errors, which is nearly
all of it if a scheme has changed little, cancels in the ratio.
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.measuring import FITTED, Estimate
from sdaeverify.numerics import GROUPS, slope_weights
from sdaeverify.studying import CALIBRATED_PATHS

from .level_errors import LevelErrors

WAS_EXACT, IS_EXACT, ORDER_ALONE = "it was exact", "it is exact now", "only its order is known"
UNTOLD = "no step size at which both errors exceed their noise"
# Relative tolerance for equal step sizes of two runs, for rounding.
SAME = 1e-9
# log2 of the ratio of two errors below which the smaller one is rounding.
ROUNDING = -20.0


class Factor(NamedTuple):
    """New error over old error, as a logarithm.

    Attributes
    ----------
    log2 : Estimate
        Estimate of log2 F; its standard error is 0 without sampling, and it is 0 if only the order is known.
    levels : int
        Number of step sizes in the mean.
    sampled : bool
    reason : str
        Why there is no factor, or a remark on it.
    order : Estimate
        New order minus old order; NaN with fewer than two common step sizes.
    """

    log2: Estimate
    levels: int = 0
    sampled: bool = False
    reason: str = ""
    order: Estimate = Estimate(nan, nan)

    @property
    def known(self) -> bool:
        """Whether the factor is known."""
        return not np.isnan(self.log2.value)

    @property
    def is_order_alone(self) -> bool:
        """Whether no error is significant in both runs, and only the change of the order is known."""
        return not self.levels and not np.isnan(self.order.value)


def factor(old: LevelErrors, new: LevelErrors) -> Factor:
    """Estimate the factor by which errors have grown from one run to another.

    Parameters
    ----------
    old, new : LevelErrors
        Errors of one quantity, on the same noise.

    Returns
    -------
    Factor
        Infinite if errors were rounding and no longer are, 0 in the opposite case.
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
    """Return the jackknife estimate of a value on all paths and without each group, or a single value as it is."""
    if len(values) == 1:
        return Estimate(float(values[0]), 0.0)
    pseudo = GROUPS * values[0] - (GROUPS - 1) * values[1:]
    return Estimate(float(pseudo.mean()), float(pseudo.std(ddof=1) / np.sqrt(GROUPS)))


def _without_common_levels(old: LevelErrors, new: LevelErrors, moved: Array) -> Factor:
    """Return the factor if no error is significant in both runs: 0, infinite, or only orders.

    Parameters
    ----------
    old, new : LevelErrors
    moved : ndarray
        Logarithms of ratios of errors, at step sizes at which one of them is significant.
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
    """Return the indices of common step sizes in the old and in the new run."""
    mine, others = np.nonzero(np.isclose(old.h[:, np.newaxis], new.h, rtol=SAME, atol=0.0))
    return mine, others


def no_factor(reason: str) -> Factor:
    """Return an unknown factor (NaN) with the reason."""
    return Factor(Estimate(nan, nan), reason=reason)
