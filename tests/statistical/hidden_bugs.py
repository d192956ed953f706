"""Equations and schemes of cells whose claims are false, although most of what one can look at agrees with them."""

from copy import copy
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from facade import EulerMaruyama, LaggedAlgebraicTheta, Milstein, MilsteinAreas, StochasticTheta
from sdaeverify import SDE, Array, Increment, Scheme, Step
from wrong.faults import Fault, Region, RememberedDrift, Window, faulty

SCALAR: dict[str, Any] = {"noise_dim": 1, "horizon": 1.0, "source": "an equation with rough coefficients"}


def kinked_noise() -> SDE:
    """Return dx = -x/2 dt + (1 + |x|/2) dW from .02: Milstein's scheme has order 3/4."""
    return SDE(
        drift=lambda t, x: -0.5 * x,
        diffusion=lambda t, x: (1.0 + 0.5 * np.where(x.real < 0.0, -x, x))[:, None],
        diffusion_derivative=lambda t, x, y: (0.5 * np.where(x.real < 0.0, -y, y))[:, None],
        start=[0.02],
        traits=frozenset({"diagonal-noise"}),
        **SCALAR,
    )


def square_root_noise() -> SDE:
    """Return dx = dt/2 + 2 sqrt(x) dW from .02, a squared Bessel process that meets 0: of order 1/4 at most."""
    return SDE(
        drift=lambda t, x: 0.5 + 0.0 * x,
        diffusion=lambda t, x: 2.0 * np.sqrt(np.maximum(x.real, 0.0))[:, None],
        diffusion_derivative=lambda t, x, y: (y / np.sqrt(np.maximum(x.real, 1e-12)))[:, None],
        start=[0.02],
        traits=frozenset({"diagonal-noise"}),
        **SCALAR,
    )


def kinked_drift() -> SDE:
    """Return dx = (1/2 - 4 x^+) dt + .8 dW from .2: schemes of order 3/2 have about 5/4."""
    return SDE(
        drift=lambda t, x: 0.5 - 4.0 * np.where(x.real > 0.0, x, 0.0 * x),
        diffusion=lambda t, x: np.full((1, 1, 1), 0.8),
        diffusion_derivative=lambda t, x, y: np.zeros((1, 1, 1)),
        start=[0.2],
        traits=frozenset({"additive-noise", "diagonal-noise"}),
        **SCALAR,
    )


def far_sine() -> SDE:
    """Return dx = (1 + x^2)^(1/2) dW + x/2 dt from -1: x = sinh(W - arsinh 1)."""
    return SDE(
        drift=lambda t, x: 0.5 * x,
        diffusion=lambda t, x: np.sqrt(1.0 + x * x)[:, None],
        diffusion_derivative=lambda t, x, y: (x * y / np.sqrt(1.0 + x * x))[:, None],
        start=[-1.0],
        traits=frozenset({"diagonal-noise"}),
        **SCALAR,
    )


class EulerBelow(Milstein):
    """Milstein's scheme that is Euler's where x < -3/2."""

    name: ClassVar[str] = "euler-below"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = super().step(problem, state, t, h, noise).state
        return Step(np.where(state[0] < -1.5, problem.euler(t, state, h, noise), new))


@dataclass(frozen=True)
class Moved(EulerMaruyama):
    """Euler-Maruyama with f(t, a x) and B(t, b x) in a window of time, from some step on, or in short steps."""

    of_drift: float = 1.0
    of_noise: float = 1.0
    begin: float = 0.0
    end: float = 10.0**6
    since: int = 0
    below: float = 10.0**6

    name: ClassVar[str] = "moved"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        wrong = self.begin <= t < self.end and round(t / h) + 1 >= self.since and h < self.below
        a, b = (self.of_drift, self.of_noise) if wrong else (1.0, 1.0)
        return Step(state + h * problem.drift(t, a * state) + problem.diffused(t, b * state, noise.dW))


class Jumping(Moved):
    """The same that declares jumps."""

    name: ClassVar[str] = "jumping"
    jumps: ClassVar[bool] = True


class WithAreas(Moved):
    """The same that declares areas."""

    name: ClassVar[str] = "with-areas"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})


@dataclass(frozen=True)
class Loud(Milstein):
    """Milstein's scheme for B(t, b x) in place of B(t, x)."""

    of_noise: float = 1.001

    name: ClassVar[str] = "loud"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        b, other = self.of_noise, copy(problem)
        object.__setattr__(other, "diffusion", lambda t, x: problem.diffusion(t, b * x))
        derivative = problem.derivative_of_diffusion
        object.__setattr__(other, "diffusion_derivative", lambda t, x, y: b * derivative(t, b * x, y))
        return super().step(other, state, t, h, noise)


class Clipped(EulerMaruyama):
    """Euler-Maruyama that is cut at |x| = 2."""

    name: ClassVar[str] = "clipped"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(np.clip(problem.euler(t, state, h, noise), -2.0, 2.0))


def stale(low: float, high: float) -> Scheme:
    """Return a scheme whose remembered drift is not renewed where the step begins between two bounds."""
    return faulty(RememberedDrift(), Fault("memory", region=Region(0, low, high)), "stale")


def unsolved(scheme: Scheme, factor: float = 0.0) -> Scheme:
    """Return a scheme of delay equations whose y is times 1 + factor where x > 6/5."""
    return faulty(scheme, Fault("algebraic", factor, region=Region(0, 1.2)), "unsolved")


UNSOLVED = (partial(unsolved, StochasticTheta(0.5), 0.1), partial(unsolved, LaggedAlgebraicTheta(), 0.1))
LESS_AREA = faulty(MilsteinAreas(), Fault("area", -0.1), "less-area")


def quiet(begin: float, end: float) -> Scheme:
    """Return Euler-Maruyama with noise that is 2 % too weak in a part of the horizon, in one dimension."""
    return faulty(EulerMaruyama(), Fault("noise", -0.02, window=Window(begin, end), rows=1), "quiet")
