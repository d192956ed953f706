"""How far the error of the reference can tilt a slope."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array
from ..reference import OWN_REFERENCE
from ..statistics import slope_weights
from ..truths import Pathwise

if TYPE_CHECKING:
    from .strong import Quantity


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


def reference_bias(truth: Pathwise | None, quantity: "Quantity", levels: Array) -> Bias:
    """Return a bound for the bias of the slope on some levels.

    A truth of strong order q, known at two resolutions that differ by D in the mean, is off by about
    D/(2^q - 1) at the finer one. With rho_l that error relative to e_l, y_l moves by at most
    -log2(1 - rho_l), and the slope by at most the sum of these with the weights' sizes. A scheme that is its own
    reference shifts y_l by log2(1 - r_l^p)/2 or log2(1 - r_l^p), r_l = h_ref/h_l (independent or coherent errors).

    Parameters
    ----------
    truth : Pathwise or None
    quantity : Quantity
    levels : ndarray of int
        Levels of the fit.

    Returns
    -------
    Bias
    """
    h = quantity.h[levels]
    weights = slope_weights(np.log2(h))
    if truth is None:
        return Bias(_own_bound(quantity, levels, weights), f"own reference {OWN_REFERENCE} levels finer", False)
    if truth.exact:
        return Bias(0.0, "exact solution", True)
    error = quantity.reference[1] / (2.0**truth.order - 1.0)
    rho = error / quantity.means()[levels]
    bound = np.abs(weights) @ -np.log2(1.0 - rho) if (rho < 1.0).all() else np.inf
    return Bias(float(bound), f"reference of order {truth.order} one level finer", True)


def _own_bound(quantity: "Quantity", levels: Array, weights: Array) -> float:
    ratio = quantity.h[-1] / 2**OWN_REFERENCE / quantity.h[levels]
    order = max(quantity.slope(levels).value, 0.5)
    coherent = weights @ np.log2(1.0 - ratio**order)
    independent = weights @ (0.5 * np.log2(1.0 - ratio ** (2.0 * order)))
    return float(max(abs(coherent), abs(independent)))
