"""Schemes that are wrong in a window of time and right before and after it: who looks elsewhere sees nothing."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.sra1 import SRA1


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


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    stale = Planted(bug="EM: half the state in an early window", scheme=StaleWindow(), problem="gbm")
    drift = Planted(
        bug="EM: drift 2 % off for two thirds of a long run",
        scheme=ScaledWindow(of_drift=0.98),
        problem="gbm[horizon=16]",
    )
    return [
        stale,
        replace(stale, bug="EM: half the state in a late window", scheme=StaleWindow(0.62, 0.66)),
        drift,
        replace(drift, bug="EM: drift 2 % off for two thirds of a long run to rest", problem="ou[horizon=16]"),
        replace(
            drift,
            bug="EM: drift 2 % off for a twentieth of a long run",
            scheme=ScaledWindow(0.07, 0.12, of_drift=0.98),
        ),
        replace(
            drift,
            bug="EM: noise 2 % off for an early twentieth",
            scheme=ScaledWindow(0.005, 0.055, noise_share=0.98),
            problem="ou",
        ),
        replace(
            drift,
            bug="EM: noise 10 % off for an eighth",
            scheme=ScaledWindow(0.53, 0.65, noise_share=1.1),
            problem="ou",
        ),
        replace(
            drift,
            bug="EM: no noise for a 64th",
            scheme=ScaledWindow(0.7, 0.7157, noise_share=0.0),
            problem="double-well",
        ),
        Planted(bug="SRA1: Euler-Maruyama for a tenth", scheme=CoarserWindow(), problem="ou"),
    ]
