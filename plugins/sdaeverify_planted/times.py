"""Schemes that are wrong in some of their steps, told by time, number or size, or in one of many noises."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.sra1 import SRA1

# Schemes that are wrong in a window of time and right before and after it: who looks elsewhere sees nothing.


@dataclass(frozen=True)
class StaleWindow(EulerMaruyama):
    """Euler-Maruyama with its coefficients at share x in place of x for begin < t < end.

    Attributes
    ----------
    begin, end : float
        In the problem's unit of time.
    share : float
    """

    begin: float = 0.02
    end: float = 0.06
    share: float = 0.5

    name: ClassVar[str] = "planted-em-window"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = self.share * state if self.begin < t < self.end else state
        return Step(state + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class ScaledWindow(EulerMaruyama):
    """Euler-Maruyama with its drift at a x and its noise times b between two parts of the horizon.

    Attributes
    ----------
    begin, end : float
        As parts of the horizon.
    of_drift, noise_share : float
        a and b.
    """

    begin: float = 0.2
    end: float = 0.87
    of_drift: float = 1.0
    noise_share: float = 1.0

    name: ClassVar[str] = "planted-em-scaled-window"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        inside = self.begin * problem.horizon < t < self.end * problem.horizon
        a, b = (self.of_drift, self.noise_share) if inside else (1.0, 1.0)
        return Step(state + h * problem.drift(t, a * state) + b * problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class CoarserWindow(SRA1):
    """SRA1 that is Euler-Maruyama between two parts of the horizon: the limit is right, the order there is 1.

    Attributes
    ----------
    begin, end : float
        As parts of the horizon.
    """

    begin: float = 0.3
    end: float = 0.4

    name: ClassVar[str] = "planted-sra1-window"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        inside = self.begin * problem.horizon < t < self.end * problem.horizon
        of: Scheme = EulerMaruyama() if inside else SRA1()
        return of.step(problem, state, t, h, noise)


# Schemes that are right in most of their steps: the others are told by their index, or by how late they are.


@dataclass(frozen=True)
class RareDrift(EulerMaruyama):
    """Euler-Maruyama that forgets the drift in one of so many steps.

    Attributes
    ----------
    every : int
    """

    every: int = 16

    name: ClassVar[str] = "planted-em-rare"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        if round(t / h) % self.every < self.every - 1:
            return super().step(problem, state, t, h, noise)
        return Step(state + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class LateDrift(EulerMaruyama):
    """Euler-Maruyama that forgets the drift from some part of the horizon on, or up to it.

    Attributes
    ----------
    since, until : float
        As parts of the horizon.
    """

    since: float = 0.9
    until: float = 1.0

    name: ClassVar[str] = "planted-em-late"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        if not self.since * problem.horizon < t + h / 2 <= self.until * problem.horizon:
            return super().step(problem, state, t, h, noise)
        return Step(state + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class RareCorrection(Milstein):
    """Milstein's scheme that is Euler's in one of so many steps, with Milstein's order claimed.

    Attributes
    ----------
    every : int
    """

    every: int = 16

    name: ClassVar[str] = "planted-milstein-rare"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        of: Scheme = Milstein() if round(t / h) % self.every else EulerMaruyama()
        return of.step(problem, state, t, h, noise)


# Schemes that count their steps, or look at their size, and are wrong from some number or size on.


@dataclass(frozen=True)
class CountedDrift(EulerMaruyama):
    """Euler-Maruyama with the drift at share x from some step on: for h to 0 that is from the start.

    Attributes
    ----------
    since : int
        Number of the first such step, counted from 1.
    share : float
        What the state is multiplied by there.
    """

    since: int = 131
    share: float = 0.5

    name: ClassVar[str] = "planted-em-counted"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = self.share * state if round(t / h) + 1 >= self.since else state
        return Step(state + h * problem.drift(t, x) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class CountedCorrection(Milstein):
    """Milstein's scheme that is Euler's from some step on.

    Attributes
    ----------
    since : int
        Number of the first such step, counted from 1.
    """

    since: int = 40

    name: ClassVar[str] = "planted-milstein-counted"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        of: Scheme = EulerMaruyama() if round(t / h) + 1 >= self.since else Milstein()
        return of.step(problem, state, t, h, noise)


@dataclass(frozen=True)
class TinySteps(EulerMaruyama):
    """Euler-Maruyama whose drift is taken at share x in steps that are shorter than some size.

    Attributes
    ----------
    below : float
        Step size, in the problem's unit of time.
    share : float
        What the state is multiplied by there.
    """

    below: float = 1e-4
    share: float = 0.5

    name: ClassVar[str] = "planted-em-tiny-steps"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = self.share * state if h < self.below else state
        return Step(state + h * problem.drift(t, x) + problem.diffused(t, state, noise.dW))


# Schemes that are wrong by little where there are many noises, whose nodes do not fit into a full grid.


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


BUGS = [
    Planted("EM: half the state in an early window", StaleWindow(), "gbm"),
    Planted("EM: half the state in a late window", StaleWindow(0.62, 0.66), "gbm"),
    Planted("EM: drift 2 % off for two thirds of a long run", ScaledWindow(of_drift=0.98), "gbm[horizon=16]"),
    Planted("EM: drift 2 % off for two thirds of a long run to rest", ScaledWindow(of_drift=0.98), "ou[horizon=16]"),
    Planted("EM: drift 2 % off for a twentieth of a long run", ScaledWindow(0.07, 0.12, 0.98), "gbm[horizon=16]"),
    Planted("EM: noise 2 % off for an early twentieth", ScaledWindow(0.005, 0.055, noise_share=0.98), "ou"),
    Planted("EM: noise 10 % off for an eighth", ScaledWindow(0.53, 0.65, noise_share=1.1), "ou"),
    Planted("EM: no noise for a 64th", ScaledWindow(0.7, 0.7157, noise_share=0.0), "double-well"),
    Planted("SRA1: Euler-Maruyama for a tenth", CoarserWindow(), "ou"),
    Planted("EM: drift forgotten in every 16th step", RareDrift(), "double-well"),
    Planted("EM: drift forgotten in every 7th step", RareDrift(7), "double-well"),
    Planted("EM: drift forgotten in every 100th step", RareDrift(100), "double-well"),
    Planted("EM: drift forgotten in every 16th step of a moving force", RareDrift(), "forced-ou"),
    Planted("EM: drift forgotten in the last tenth", LateDrift(), "double-well"),
    Planted("EM: drift forgotten in between", LateDrift(0.5, 0.6), "double-well"),
    Planted("Milstein: Euler in every 16th step", RareCorrection(), "gbm"),
    Planted("EM: drift of half the state from the 131st step on", CountedDrift(), "gbm"),
    Planted("EM: drift of half the state from the 40th step on", CountedDrift(40), "gbm"),
    Planted("EM: drift of half the state from the 200th step on", CountedDrift(200), "ou"),
    Planted("Milstein: Euler from the 40th step on", CountedCorrection(), "gbm"),
    Planted("EM: drift of half the state where h < 1e-4", TinySteps(), "gbm"),
    Planted("EM: drift of half the state where h < 1e-3", TinySteps(0.001), "ou"),
    Planted("EM: drift at 0.997 x with 12 noises", ManyScaled(), "fibre-linear[N=12]"),
    Planted("EM: drift at 0.999 x with 24 noises", ManyScaled(0.999), "fibre-linear[N=24]"),
    Planted("EM: one noise of 12 x 1.01", ManyScaled(1.0, 7, 1.01), "fibre-linear[N=12]"),
    Planted("EM: one noise of 24 x 1.01", ManyScaled(1.0, 7, 1.01), "fibre-linear[N=24]"),
    Planted("SRA1: one integral of 12 halved", ManyIntegrals(), "fibre-linear[N=12]"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
