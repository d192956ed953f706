"""Schemes that are wrong by little where there are many noises, whose nodes do not fit into a full grid."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.sra1 import SRA1

TWELVE, TWENTY_FOUR = "fibre-linear[N=12]", "fibre-linear[N=24]"


def with_share(noise: Array, motion: int, share: float) -> Array:
    """Return noise with one row times a share, where there are more than four.

    Parameters
    ----------
    noise : ndarray, shape (l, P)
    motion : int
        Index of the row.
    share : float
    """
    scaled = np.array(noise)
    if len(scaled) > 4:
        scaled[motion] *= share
    return scaled


@dataclass(frozen=True)
class ManyScaled(EulerMaruyama):
    """x+ = x + h f(t, a x) + B(t, x) dW, with one noise that is scaled where there are more than four.

    Attributes
    ----------
    of_drift : float
        a.
    motion : int
        Index of the noise.
    noise_share : float
        What it is multiplied by.
    """

    of_drift: float = 0.997
    motion: int = 0
    noise_share: float = 1.0

    name: ClassVar[str] = "planted-em-many"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        kick = problem.diffused(t, state, with_share(noise.dW, self.motion, self.noise_share))
        return Step(state + h * problem.drift(t, self.of_drift * state) + kick)


@dataclass(frozen=True)
class ManyIntegrals(SRA1):
    """SRA1 with one time integral of the noise that is scaled where there are more than four: of strong order 1.

    Attributes
    ----------
    motion : int
        Index of the noise.
    share : float
        What its integral H is multiplied by.
    """

    motion: int = 5
    share: float = 0.5

    name: ClassVar[str] = "planted-sra1-many"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        given = noise if noise.H is None else noise._replace(H=with_share(noise.H, self.motion, self.share))
        return super().step(problem, state, t, h, given)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    drift = Planted(bug="EM: drift at 0.997 x with 12 noises", scheme=ManyScaled(), problem=TWELVE)
    one = Planted(bug="EM: one noise of 12 x 1.01", scheme=ManyScaled(1.0, 7, 1.01), problem=TWELVE)
    return [
        drift,
        replace(drift, bug="EM: drift at 0.999 x with 24 noises", scheme=ManyScaled(0.999), problem=TWENTY_FOUR),
        one,
        replace(one, bug="EM: one noise of 24 x 1.01", problem=TWENTY_FOUR),
        Planted(bug="SRA1: one integral of 12 halved", scheme=ManyIntegrals(), problem=TWELVE),
    ]
