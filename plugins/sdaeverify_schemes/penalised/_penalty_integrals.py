"""Exact effect of the penalty on zeta in one step."""

from typing import NamedTuple

import numpy as np


class PenaltyIntegrals(NamedTuple):
    """Integrals of the relaxation e^{-t/eps} over a step.

    Attributes
    ----------
    e : float
        Exponential e^{-h/eps}.
    omega : float
        Difference 1 - e.
    first : float
        int_0^h e^{-s/eps} ds = eps omega.
    second : float
        int_0^h e^{-2s/eps} ds = (eps/2) (1 - e^2).
    """

    e: float
    omega: float
    first: float
    second: float

    @classmethod
    def over(cls, h: float, eps: float) -> "PenaltyIntegrals":
        """Return the integrals over a step of size h, without cancellation for any eps from 0 to infinity."""
        z = h / eps if eps else np.inf
        with np.errstate(over="ignore"):
            return cls(float(np.exp(-z)), float(-np.expm1(-z)), h * _mean(z), h * _mean(2.0 * z))


def _mean(z: float) -> float:
    """Return (1 - e^{-z})/z, the mean of e^{-s} over 0 < s < z."""
    return float(-np.expm1(-z) / z) if z else 1.0
