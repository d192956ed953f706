"""By which factor the errors of a quantity have grown: a paired estimate on common noise.

With the mean errors e_l of the old run and e'_l of the new one at the finest step sizes that both could fit,

    log2 F = mean_l log2(e'_l/e_l),

and the order has changed by the slope of log2(e'_l/e_l) against log2 h_l.

Both runs leave the same groups of paths out of the jackknife. What their errors have in common, which is nearly all
that is random in them where a scheme has changed little, cancels in the ratio.
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.error_sizes import ErrorSizes
from ...numerics.statistics import GROUPS, Estimate, slope_weights
from ...verdicts.path_tests import CALIBRATED_PATHS, FITTED

BOTH_EXACT, WAS_EXACT, IS_EXACT = "exact in both runs", "it was exact", "it is exact now"
# Step sizes of two runs are the same up to rounding.
SAME = 1e-9


class Factor(NamedTuple):
    """New error over old error.

    Attributes
    ----------
    log2 : Estimate
        Of its logarithm; without standard error where nothing is sampled.
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


def factor(old: ErrorSizes, new: ErrorSizes) -> Factor:
    """Return by which factor errors have grown from one run to another.

    Parameters
    ----------
    old, new : ErrorSizes
        Of one quantity, on the same noise.

    Returns
    -------
    Factor
        Infinite where errors were rounding and are not now, 0 the other way round.
    """
    if old.exact or new.exact:
        return _with_exact(old, new)
    if obstacle := _obstacle(old, new):
        return _no_factor(obstacle)
    mine, others = _common(old, new)
    if not len(mine):
        return _no_factor("; ".join(["no step size at which both errors can be told", *_remarks(old, new)]))
    mean = np.full(len(mine), 1.0 / len(mine))
    slope = slope_weights(np.log2(old.h[mine])) if len(mine) > 1 else np.full(1, nan)
    if old.replicates is None or new.replicates is None:
        moved = new.log2[others] - old.log2[mine]
        size, order = (Estimate(float(weights @ moved), 0.0) for weights in (mean, slope))
        return Factor(size, len(mine), order=order)
    size, order = (_estimate((new.replicates[:, others] - old.replicates[:, mine]) @ w) for w in (mean, slope))
    return Factor(size, len(mine), sampled=True, order=order)


def _estimate(pseudo: Array) -> Estimate:
    return Estimate(float(pseudo.mean()), float(pseudo.std(ddof=1) / np.sqrt(GROUPS)))


def _with_exact(old: ErrorSizes, new: ErrorSizes) -> Factor:
    if old.exact and new.exact:
        return Factor(Estimate(0.0, 0.0), reason=BOTH_EXACT)
    reason, other = (WAS_EXACT, new) if old.exact else (IS_EXACT, old)
    if not len(other.h):
        return _no_factor(f"{reason}, and the other run has no step size to tell an error at")
    return Factor(Estimate(inf if old.exact else -inf, 0.0), reason=reason)


def _obstacle(old: ErrorSizes, new: ErrorSizes) -> str:
    if (old.counts is None) != (new.counts is None):
        return "sampled in one run only"
    if old.counts is None or new.counts is None:
        return ""
    if not np.array_equal(old.counts, new.counts):
        return f"{old.counts.sum():.0f} paths in one run, {new.counts.sum():.0f} in the other"
    if old.counts.sum() < CALIBRATED_PATHS:
        return f"{old.counts.sum():.0f} common paths, intervals are calibrated from {CALIBRATED_PATHS} on"
    return ""


def _common(old: ErrorSizes, new: ErrorSizes) -> tuple[Array, Array]:
    """Return the places of the finest step sizes that both have, in either."""
    pairs = [
        (i, j)
        for i, h in enumerate(old.h)
        for j in np.flatnonzero(np.isclose(new.h, h, rtol=SAME, atol=0.0))
        if _finite(old, i) and _finite(new, int(j))
    ]
    kept = np.array(pairs[-FITTED:], dtype=int).reshape(-1, 2)
    return kept[:, 0], kept[:, 1]


def _remarks(old: ErrorSizes, new: ErrorSizes) -> list[str]:
    if old.remark == new.remark:
        return [old.remark] if old.remark else []
    return [f"{name}: {sizes.remark}" for name, sizes in (("old", old), ("new", new)) if sizes.remark]


def _finite(sizes: ErrorSizes, level: int) -> bool:
    replicates = sizes.replicates
    return bool(np.isfinite(sizes.log2[level]) and (replicates is None or np.isfinite(replicates[:, level]).all()))


def _no_factor(reason: str) -> Factor:
    return Factor(Estimate(nan, nan), reason=reason)
