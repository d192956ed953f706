"""Whether a solver tends to a wrong limit: its signed mean error has to fall as the claimed rate allows.

Let m_k = E e(tau_k) be the mean error of a component at tolerance tau_k, K the finest and J a coarser one. A claim of
the rate q with a margin says of an error that vanishes that

    |m_K| <= r_J |m_J|,   r_J = (tau_K/tau_J)^(q - margin).

With an error L that stays, m_k = L + C tau_k^(q - margin), the mean extrapolates to

    L = (m_K - r_J m_J)/(1 - r_J).

The hypothesis is rejected where s m_K > r_J |m_J| for every J and one sign s: where a mean happens to be small at a
coarser tolerance, another one speaks for the solver. All means are of the same paths, so that the variance of a
difference is that of the pairs.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.measuring import Estimate, jackknife


class Limit(NamedTuple):
    """What paths say of the limit of one component.

    Attributes
    ----------
    p : float
        p-value of the hypothesis that its mean error falls as claimed.
    extrapolated : Estimate
        L of the coarser tolerance that speaks most for the solver.
    resolution : float
        Largest |L| that the sample leaves possible, in the unit of the component.
    """

    p: float
    extrapolated: Estimate
    resolution: float


def limit(sums: Array, counts: Array, ratios: Array, bias: float, confidence: float) -> Limit:
    """Return whether a mean error tends to something else than 0.

    Parameters
    ----------
    sums : ndarray, shape (G, K)
        Sums of the signed error over each group of paths, the finest tolerance last.
    counts : ndarray, shape (G,)
        Paths of each group.
    ratios : ndarray, shape (K - 1,)
        r_J of each coarser tolerance.
    bias : float
        How far a mean may be off for other reasons: rounding, the truth's own error.
    confidence : float
        Of the resolution's interval.
    """
    found = [_against(sums, counts, J, r, bias) for J, r in enumerate(ratios)]
    signs = [max(p[sign] for p, _ in found) for sign in (0, 1)]
    p, sign = min(2.0 * min(signs), 1.0), int(np.argmin(signs))
    extrapolated = max(found, key=lambda each: each[0][sign])[1]
    return Limit(p, extrapolated, max(map(abs, extrapolated.interval(confidence, bias))))


def _against(sums: Array, counts: Array, J: int, r: float, bias: float) -> tuple[tuple[float, float], Estimate]:
    """Return the p-values of both signs against one coarser tolerance, and the limit that it extrapolates to."""

    def combined(factor: float) -> Estimate:
        return jackknife(sums, counts, lambda means: float(means[-1] + factor * means[J]))

    # With both signs of m_J, as its own is not known.
    either = [combined(-r), combined(r)]
    above = max(each.p_above(0.0, (1.0 + r) * bias) for each in either)
    below = max(each.p_below(0.0, (1.0 + r) * bias) for each in either)
    value, se = (part / (1.0 - r) for part in either[0])
    return (above, below), Estimate(value, se)
