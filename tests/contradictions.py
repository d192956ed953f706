"""Wrong schemes, and right ones beyond their claims, of which one step shows nothing: paths contradict."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from facade import SRA1, EulerMaruyama, Milstein
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step
from sdaeverify.numerics import apply

HALF, ONE = (Claim(measure="strong", value=order, source="planted") for order in (0.5, 1.0))
WEAK_ONE = Claim(measure="weak", value=1.0, source="planted")
EULER, MILSTEIN = EulerMaruyama(), Milstein()


@dataclass(frozen=True)
class EulerInStrip(Scheme):
    """Euler-Maruyama where x lies in a strip, Milstein elsewhere: of order 1/2."""

    low: float
    high: float

    name: ClassVar[str] = "euler-in-strip"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (ONE, WEAK_ONE)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        simple, better = (scheme.step(problem, state, t, h, noise).state for scheme in (EULER, MILSTEIN))
        return Step(np.where((self.low < state[0]) & (state[0] < self.high), simple, better))


@dataclass(frozen=True)
class TooMuchNoise(Milstein):
    """Milstein's scheme with a little more noise where that depends on the state: paths and their errors hide it."""

    excess: float = 1e-6

    name: ClassVar[str] = "too-much-noise"
    claims: ClassVar[tuple[Claim, ...]] = (ONE, WEAK_ONE)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        x = MILSTEIN.step(problem, state, t, h, noise).state
        B, elsewhere = (problem.diffusion(t, each) for each in (state, 2.0 * state + 1.0))
        return Step(x + self.excess * apply(np.where(elsewhere == B, 0.0, B), noise.dW))


class Clipped(EulerMaruyama):
    """Euler-Maruyama that goes on from |x| = 2 where |x| is larger."""

    name: ClassVar[str] = "clipped"
    claims: ClassVar[tuple[Claim, ...]] = (ONE,)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return EULER.step(problem, np.clip(state, -2.0, 2.0), t, h, noise)


class ModestSRA1(SRA1):
    """SRA1 of which the order 1 is claimed, which it has where the drift has a kink."""

    name: ClassVar[str] = "modest-sra1"
    claims: ClassVar[tuple[Claim, ...]] = (ONE,)


def kinked() -> SDE:
    """Multiplicative noise with a kink: dx = (1 + |x|/2) dW, x(0) = 1/2."""
    return SDE(
        drift=lambda t, x: 0.0 * x,
        diffusion=lambda t, x: (1.0 + 0.5 * np.abs(x))[:, None],
        diffusion_derivative=lambda t, x, y: (0.5 * np.sign(x) * y)[:, None],
        start=[0.5],
        noise_dim=1,
        horizon=1.0,
        noise=frozenset({"dW"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="planted",
    )


def squared_motion() -> SDE:
    """Squared Bessel process that reaches zero: dx = dt/2 + 2 sqrt(x) dW."""
    return SDE(
        drift=lambda t, x: 0.5 + 0.0 * x,
        diffusion=lambda t, x: 2.0 * np.sqrt(np.maximum(x, 0.0))[:, None],
        start=[0.1],
        noise_dim=1,
        horizon=1.0,
        noise=frozenset({"dW"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="planted",
    )


def bent_drift(start: float = 0.1) -> SDE:
    """Additive noise with a kink in the drift: dx = (1/2 - 4 max(x, 0)) dt + 0.8 dW."""
    return SDE(
        drift=lambda t, x: 0.5 - 4.0 * np.maximum(x, 0.0),
        diffusion=lambda t, x: (0.8 + 0.0 * x)[:, None],
        start=[start],
        noise_dim=1,
        horizon=1.0,
        noise=frozenset({"dW", "H"}),
        traits=frozenset({"additive-noise"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="planted",
    )


def bent_at_start() -> SDE:
    """Return the same that starts on the kink."""
    return bent_drift(0.0)


def waves() -> SDE:
    """Multiplicative noise that does not grow: dx = (1 + sin(x)/2) dW."""
    return SDE(
        drift=lambda t, x: 0.0 * x,
        diffusion=lambda t, x: (1.0 + 0.5 * np.sin(x))[:, None],
        diffusion_derivative=lambda t, x, y: (0.5 * np.cos(x) * y)[:, None],
        start=[0.5],
        noise_dim=1,
        horizon=1.0,
        noise=frozenset({"dW"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="planted",
    )


def switched(at: float) -> SDE:
    """Noise that doubles at a time, when the drift turns: dx = (-x + sign(t - at)) dt + (1 + [t > at])/2 dW."""
    return SDE(
        drift=lambda t, x: -x + (1.0 if t > at else -1.0),
        diffusion=lambda t, x: np.full((1, 1, 1), 1.0 if t > at else 0.5),
        diffusion_derivative=lambda t, x, y: np.zeros((1, 1, 1)),
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        traits=frozenset({"vanishing-milstein-term"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="planted",
    )


def switched_late() -> SDE:
    """Return it with a time that no mesh has."""
    return switched(0.7)


def switched_on_mesh() -> SDE:
    """Return it with a time that all meshes have, and at which single steps are probed."""
    return switched(0.5)
