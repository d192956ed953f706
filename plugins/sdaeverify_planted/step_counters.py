"""Schemes that count their steps, or look at their size, and are wrong from some number or size on."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein


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


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    counted = Planted(bug="EM: drift of half the state from the 131st step on", scheme=CountedDrift(), problem="gbm")
    return [
        counted,
        replace(counted, bug="EM: drift of half the state from the 40th step on", scheme=CountedDrift(40)),
        replace(
            counted, bug="EM: drift of half the state from the 200th step on", scheme=CountedDrift(200), problem="ou"
        ),
        Planted(bug="Milstein: Euler from the 40th step on", scheme=CountedCorrection(), problem="gbm"),
        Planted(bug="EM: drift of half the state where h < 1e-4", scheme=TinySteps(), problem="gbm"),
        Planted(bug="EM: drift of half the state where h < 1e-3", scheme=TinySteps(1e-3), problem="ou"),
    ]
