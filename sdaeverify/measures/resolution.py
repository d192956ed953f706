"""Resolution of a verdict: the smallest error of the limit that would have been detected.

Let x be the solution, x_L the result of a scheme with the finest steps of a run, and y its limit as h tends to 0. For
any y,

    |y - x| <= |x_L - x| + |x_L - y|,     |x_L - y| <= |x_{L-1} - x_L| / (2^p - 1)

if the scheme's own differences fall with the order p, which a verdict grants. Both terms on the right are
measured, in the mean over paths for strong errors and as differences of means for weak ones. With the upper ends of
their intervals the right side bounds every error of the limit that the evidence leaves possible; a larger error would
have been detected.

If only the scheme itself provides the limit along paths, single steps are used: they were compared with the
equation at n random times, one in each part of the run, and drift and noise differ by at most e times the
solution's motion there. The probability that all n times miss a share s of a run is at most (1 - s)^n, which is
at most alpha for s >= -log(alpha)/n. Steps that are wrong there by all of their motion move the limit by s times the
solution's motion, if errors do not grow. The number of states at each time does not matter for a window of time.
"""

from math import inf, isfinite, log, nan

import numpy as np

from ..arrays import Array
from ..conformance.violation import LAW
from ..contracts.claimed import Order
from ..contracts.measure import Evidence
from ..contracts.scheme import Claim
from ..contracts.tally import unpacked
from ..numerics.statistics import EPS, Estimate, estimates, leave_out
from ..probe.local.step_law import LawResolution
from .means import Means
from .path_errors.quantity import Quantity

# A claim of exactness grants no order: the scheme's differences are as small as its errors.
# Theorem: orders are multiples of 1/2.
LEAST_ORDER = 0.5
# A mean below this size is treated as 0.
# Rounding: pairwise sums of n values err by (log2 n + 19) eps of their sizes (Higham 2002, 4.2), 64 eps for n < 2^45.
ROUNDING = 64.0 * EPS


def granted_order(claim: Claim) -> float:
    """Return the order that a verified claim grants: its smallest accepted one."""
    return float(claim.value.floor) if isinstance(claim.value, Order) else LEAST_ORDER


def bound_limit_error(error: float, change: float, order: float) -> float:
    """Return the bound of |y - x|, given bounds of |x_L - x| and |x_{L-1} - x_L|.

    Parameters
    ----------
    error, change : float
        Upper ends of their intervals.
    order : float
        p, that of the scheme's own differences.
    """
    return float(error + change / (2.0**order - 1.0))


def strong_resolution(evidence: Evidence, quantity: Quantity, finest: int, claim: Claim | None) -> float:
    """Return the resolution of errors along paths, relative to the mean motion of the component.

    Parameters
    ----------
    evidence : Evidence
    quantity : Quantity
        Errors along paths, one for each level.
    finest : int
        The finest usable level.
    claim : Claim or None

    Returns
    -------
    float
        NaN without a claim; that of single steps if the scheme is its own reference, which does not know the true
        limit.
    """
    if claim is None:
        return nan
    if evidence.problem.pathwise is None:
        return step_resolution(evidence)
    size = _motion(quantity)
    if not size > 0.0 or finest == 0:
        return inf
    confidence = evidence.settings.confidence
    error = _upper(quantity.error[:, finest, 1], quantity.counts, confidence)
    change = _upper(quantity.difference[:, finest - 1], quantity.counts, confidence)
    found = bound_limit_error(error + _own_error(evidence, quantity, finest), change, granted_order(claim))
    return found / size if isfinite(found) else inf


def weak_resolution(
    evidence: Evidence, means: Means, off: tuple[Estimate, float] | None, claim: Claim | None
) -> float:
    """Return the resolution of means along paths, relative to the mean size of the observable.

    Parameters
    ----------
    evidence : Evidence
    means : Means
        Of one observable, on each level.
    off : (Estimate, float) or None
        Distance of the finest mean from the known limit, and the error of the latter; None if the exact solution is
        known on each path, or if the limit is unknown.
    claim : Claim or None

    Returns
    -------
    float
        NaN without a claim; that of single steps if the limit is unknown.
    """
    if claim is None:
        return nan
    if not (means.coupled or off):
        return step_resolution(evidence)
    finest, confidence = len(means.h) - 1, evidence.settings.confidence
    if not means.size > 0.0:
        return inf
    error, own = (means.difference(finest), 0.0) if off is None else off
    change = means.change(np.array([finest - 1])) if not means.coupled else _gap(means, finest)
    distance, step = (max(map(abs, each.interval(confidence))) for each in (error, change))
    found = bound_limit_error(distance + own, step, granted_order(claim))
    return found / means.size if isfinite(found) else inf


def stationary_resolution(errors: Array, off: Array, size: float, claim: Claim | None) -> float:
    """Return the resolution of stationary means at some step sizes, relative to their size; NaN without a claim.

    A bias that is claimed to have no order is bounded at the step size where it is largest.

    Parameters
    ----------
    errors, off : ndarray, shape (H,)
        Biases from the coarsest step size to the finest, and bounds of their numerical or sampling errors.
    size : float
        Of the exact mean; if it is 0 up to rounding, the resolution is absolute.
    claim : Claim or None
    """
    if claim is None:
        return nan
    most, steps = np.abs(errors) + off, np.abs(np.diff(errors)) + off[:-1] + off[1:]
    unit, known = size if size > ROUNDING else 1.0, np.isfinite(most)
    if not isinstance(claim.value, Order):
        return float(most.max() / unit) if known.all() and len(most) else inf
    bounds = most[1:] + steps / (2.0 ** granted_order(claim) - 1.0)
    return float(np.min(bounds, where=np.isfinite(bounds), initial=inf) / unit)


def _gap(means: Means, finest: int) -> Estimate:
    """Return E [phi(x_{L-1}) - phi(x_L)] for means whose differences are relative to the exact solution."""
    return estimates(leave_out(means.sums[:, finest - 1] - means.sums[:, finest], means.counts))[0]


def _motion(quantity: Quantity) -> float:
    return quantity.motion if isfinite(quantity.motion) and quantity.motion > 0.0 else quantity.size


def _own_error(evidence: Evidence, quantity: Quantity, level: int) -> float:
    """Return the error of a reference of order q: half its resolution changes errors by 2^q - 1 times this."""
    truth = evidence.problem.pathwise
    if truth is None or truth.exact or quantity.blurred is None:
        return 0.0
    change = (quantity.blurred[:, level] - quantity.error[:, level, 1]).sum() / quantity.counts.sum()
    return float(abs(change) / (2.0**truth.order - 1.0))


def _upper(sums: Array, counts: Array, confidence: float) -> float:
    return max(estimates(leave_out(sums, counts))[0].interval(confidence))


def step_resolution(evidence: Evidence) -> float:
    """Return the resolution of single steps, relative to the solution's motion; infinite if they were not made."""
    found = unpacked(LAW, LawResolution, evidence.without_paths)
    if found is None:
        return inf
    missed = -log(1.0 - evidence.settings.confidence) / float(found.times)
    return max(float(found.rate_error), min(1.0, missed))
