"""Coefficients of the uniformly accurate step."""

from typing import NamedTuple

import numpy as np

from sdaeverify import ConstrainedLangevin

from ._penalty_integrals import PenaltyIntegrals


class Weights(NamedTuple):
    """Coefficients of the terms of a step.

    Attributes
    ----------
    quadratic, fixman : float
        Coefficients of g'(w) c and of grad ln det G in the predictor.
    zeta, noise, drift, turning, divergence : float
        Coefficients of zeta, g^T sqrt(h) xi, g^T f, g^T grad ln det G and div g in the level.
    """

    quadratic: float
    fixman: float
    zeta: float
    noise: float
    drift: float
    turning: float
    divergence: float

    @classmethod
    def of(cls, problem: ConstrainedLangevin, h: float, theta: float) -> "Weights":
        """Return the coefficients of a step of size h, for any eps from 0 to infinity."""
        over, variance = PenaltyIntegrals.over(h, problem.eps), problem.strength**2
        explicit = 1.0 - 2.0 * theta
        spread = explicit * over.second + 2.0 * theta * float(np.sqrt(h * over.second))
        return cls(
            quadratic=0.5 * explicit * over.omega**2,
            fixman=0.25 * variance * spread,
            zeta=over.e,
            noise=problem.strength * float(np.sqrt(over.second / h)),
            drift=over.first,
            turning=0.25 * variance * over.first,
            divergence=0.5 * variance * over.first,
        )
