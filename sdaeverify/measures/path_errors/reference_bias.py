"""How far the error of the reference can tilt a slope."""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms.truths import Pathwise
from ...numerics.statistics import slope_weights
from ...simulate.reference import OWN_REFERENCE
from .quantity import Quantity


class Bias(NamedTuple):
    """A bound of the slope's bias.

    Attributes
    ----------
    bound : float
        In units of order, to be added to an interval on either side; infinite if nothing can be said.
    reference : str
        What was compared with.
    knows_limit : bool
        Whether the reference is independent of the scheme, so that a wrong limit would show.
    """

    bound: float
    reference: str
    knows_limit: bool


def reference_bias(truth: Pathwise | None, quantity: Quantity, levels: Array, confidence: float) -> Bias:
    """Return a bound for the bias of the slope on some levels.

    The error of a truth of strong order q falls by 2^q (and its effect on the slope by at least as much) as its
    resolution doubles. So if the slope changes by D between half and full resolution, its bias at full resolution
    is at most |D|/(2^q - 1); D is measured on the same paths, and the far end of its interval is taken. A scheme
    that is its own reference shifts y_l by log2(1 - r_l^p)/2 or log2(1 - r_l^p), r_l = h_ref/h_l (independent or
    coherent errors).

    Parameters
    ----------
    truth : Pathwise or None
    quantity : Quantity
    levels : ndarray of int
        Levels of the fit.
    confidence : float
        Of the interval of D.

    Returns
    -------
    Bias
    """
    if truth is None:
        return Bias(_own_bound(quantity, levels), f"own reference {OWN_REFERENCE} levels finer", False)
    if truth.exact:
        return Bias(0.0, "exact solution", True)
    change = max(map(abs, quantity.blur(levels).interval(confidence)))
    return Bias(change / (2.0**truth.order - 1.0), f"reference of order {truth.order} one level finer", True)


def _own_bound(quantity: Quantity, levels: Array) -> float:
    h = quantity.h[levels]
    weights = slope_weights(np.log2(h))
    ratio = quantity.h[-1] / 2**OWN_REFERENCE / h
    order = max(quantity.slope(levels).value, 0.5)
    coherent = weights @ np.log2(1.0 - ratio**order)
    independent = weights @ (0.5 * np.log2(1.0 - ratio ** (2.0 * order)))
    return float(max(abs(coherent), abs(independent)))
