"""Test for a wrong limit of a solver: its signed mean error has to decrease at the claimed rate.

Let m_k = E e(tau_k) be the mean error of a component at tolerance tau_k, K the finest and J a coarser one. If the
error vanishes, a claim of the rate q with a margin implies

    |m_K| <= r_J |m_J|,   r_J = (tau_K/tau_J)^(q - margin).

With a remaining error L, m_k = L + C tau_k^(q - margin), the mean extrapolates to

    L = (m_K - r_J m_J)/(1 - r_J).

The hypothesis is rejected if s m_K > r_J |m_J| for every J and one sign s, because a mean at a single coarser
tolerance may be small by chance. All means are over the same paths, so that the variance of a difference is that of
the pairs.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.measuring import Estimate, jackknife


class Limit(NamedTuple):
    """Test of the limit of one component.

    Attributes
    ----------
    p : float
        p-value of the hypothesis that the mean error decreases as claimed.
    extrapolated : Estimate
        L for the coarser tolerance with the largest p-value.
    resolution : float
        Upper bound of the interval of |L|, in the unit of the component.
    """

    p: float
    extrapolated: Estimate
    resolution: float


def limit(sums: Array, counts: Array, ratios: Array, bias: float, confidence: float) -> Limit:
    """Test whether a mean error converges to a nonzero limit.

    Parameters
    ----------
    sums : ndarray, shape (G, K)
        Sums of the signed error over each group of paths, the finest tolerance last.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    ratios : ndarray, shape (K - 1,)
        Ratio r_J of each coarser tolerance.
    bias : float
        Bound on the bias of a mean for other reasons: rounding, error of the truth.
    confidence : float
        Confidence of the interval for the resolution.
    """
    found = [_against(sums, counts, J, r, bias) for J, r in enumerate(ratios)]
    signs = [max(p[sign] for p, _ in found) for sign in (0, 1)]
    p, sign = min(2.0 * min(signs), 1.0), int(np.argmin(signs))
    extrapolated = max(found, key=lambda each: each[0][sign])[1]
    return Limit(p, extrapolated, max(map(abs, extrapolated.interval(confidence, bias))))


def _against(sums: Array, counts: Array, J: int, r: float, bias: float) -> tuple[tuple[float, float], Estimate]:
    """Return the p-values of both signs against one coarser tolerance, and the extrapolated limit."""

    def combined(factor: float) -> Estimate:
        return jackknife(sums, counts, lambda means: float(means[-1] + factor * means[J]))

    # Both signs of m_J are tested, because its sign is unknown.
    either = [combined(-r), combined(r)]
    above = max(each.p_above(0.0, (1.0 + r) * bias) for each in either)
    below = max(each.p_below(0.0, (1.0 + r) * bias) for each in either)
    value, se = (part / (1.0 - r) for part in either[0])
    return (above, below), Estimate(value, se)
