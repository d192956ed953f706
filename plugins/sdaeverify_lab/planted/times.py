"""Schemes that are wrong in some of their steps, by time, number or size, or in one of many noises."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.sra1 import SRA1

from ._within import EulerWithin, ScaledEuler

# Schemes that are wrong only within a window of steps, so that other steps do not show the error.


class SRA1Within(EulerWithin, SRA1):
    """SRA1 that is Euler-Maruyama within a range."""

    name: ClassVar[str] = "planted-sra1-window"


class MilsteinWithin(EulerWithin, Milstein):
    """Milstein's scheme that is Euler-Maruyama within a range."""

    name: ClassVar[str] = "planted-milstein-window"


# Schemes with a small error for many noises, for which a full grid of nodes is too large.


def with_share(noise: Array, motion: int, share: float) -> Array:
    """Scale one row of noise by a factor, if there are more than four rows.

    Parameters
    ----------
    noise : ndarray, shape (l, P)
    motion : int
        Index of the row.
    share : float
        Factor of the row.
    """
    scaled = np.array(noise)
    if len(scaled) > 4:
        scaled[motion] *= share
    return scaled


@dataclass(frozen=True)
class ManyScaled(EulerMaruyama):
    """Euler-Maruyama with one scaled noise if there are more than four.

    Attributes
    ----------
    motion : int
        Index of the noise.
    noise_share : float
        Factor of the noise.
    """

    motion: int = 7
    noise_share: float = 1.01

    name: ClassVar[str] = "planted-em-many"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        given = noise._replace(dW=with_share(noise.dW, self.motion, self.noise_share))
        return super().step(problem, state, t, h, given)


@dataclass(frozen=True)
class ManyIntegrals(SRA1):
    """SRA1 with one scaled time integral of the noise if there are more than four: of strong order 1.

    Attributes
    ----------
    motion : int
        Index of the noise.
    share : float
        Factor of the integral H.
    """

    motion: int = 5
    share: float = 0.5

    name: ClassVar[str] = "planted-sra1-many"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        given = noise if noise.H is None else noise._replace(H=with_share(noise.H, self.motion, self.share))
        return super().step(problem, state, t, h, given)


LONG, SHORT = (ScaledEuler("part", *ends, of_drift=0.98) for ends in ((0.2, 0.87), (0.07, 0.12)))
WITHOUT_DRIFT = ScaledEuler("step of 16", 16, drift=0.0)
BUGS = [
    Planted("EM: half the state in an early window", ScaledEuler("time", 0.02, 0.06, 1.0, 1.0, 0.5, 0.5), "gbm"),
    Planted("EM: half the state in a late window", ScaledEuler("time", 0.62, 0.66, 1.0, 1.0, 0.5, 0.5), "gbm"),
    Planted("EM: drift 2 % off for two thirds of a long run", LONG, "gbm[horizon=16]"),
    Planted("EM: drift 2 % off for two thirds of a long run to rest", LONG, "ou[horizon=16]"),
    Planted("EM: drift 2 % off for a twentieth of a long run", SHORT, "gbm[horizon=16]"),
    Planted("EM: noise 2 % off for an early twentieth", ScaledEuler("part", 0.005, 0.055, 1.0, 0.98), "ou"),
    Planted("EM: noise 10 % off for an eighth", ScaledEuler("part", 0.53, 0.65, 1.0, 1.1), "ou"),
    Planted("EM: no noise for a 64th", ScaledEuler("part", 0.7, 0.7157, noise_share=0.0), "double-well"),
    Planted("SRA1: Euler-Maruyama for a tenth", SRA1Within("part", 0.3, 0.4), "ou"),
    Planted("EM: drift forgotten in every 16th step", WITHOUT_DRIFT, "double-well"),
    Planted("EM: drift forgotten in every 7th step", ScaledEuler("step of 7", 7, drift=0.0), "double-well"),
    Planted("EM: drift forgotten in every 100th step", ScaledEuler("step of 100", 100, drift=0.0), "double-well"),
    Planted("EM: drift forgotten in every 16th step of a moving force", WITHOUT_DRIFT, "forced-ou"),
    Planted("EM: drift forgotten in the last tenth", ScaledEuler("part", 0.9, drift=0.0), "double-well"),
    Planted("EM: drift forgotten in between", ScaledEuler("part", 0.5, 0.6, 0.0), "double-well"),
    Planted("Milstein: Euler in every 16th step", MilsteinWithin("step of 16", high=2), "gbm"),
    Planted("EM: drift of half the state from the 131st step on", ScaledEuler("step", 131, of_drift=0.5), "gbm"),
    Planted("EM: drift of half the state from the 40th step on", ScaledEuler("step", 40, of_drift=0.5), "gbm"),
    Planted("EM: drift of half the state from the 200th step on", ScaledEuler("step", 200, of_drift=0.5), "ou"),
    Planted("Milstein: Euler from the 40th step on", MilsteinWithin("step", 40), "gbm"),
    Planted("EM: drift of half the state where h < 1e-4", ScaledEuler("h", high=1e-4, of_drift=0.5), "gbm"),
    Planted("EM: drift of half the state where h < 1e-3", ScaledEuler("h", high=1e-3, of_drift=0.5), "ou"),
    Planted("EM: drift at 0.997 x with 12 noises", ScaledEuler(of_drift=0.997), "fibre-linear[N=12]"),
    Planted("EM: drift at 0.999 x with 24 noises", ScaledEuler(of_drift=0.999), "fibre-linear[N=24]"),
    Planted("EM: one noise of 12 x 1.01", ManyScaled(), "fibre-linear[N=12]"),
    Planted("EM: one noise of 24 x 1.01", ManyScaled(), "fibre-linear[N=24]"),
    Planted("SRA1: one integral of 12 halved", ManyIntegrals(), "fibre-linear[N=12]"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
