"""Schemes whose memory of steps before spoils, or makes, their order: what `enter` sets is as it should be."""

from dataclasses import dataclass
from math import ceil
from typing import Any, ClassVar, NamedTuple

import numpy as np

from facade import HalfExplicitEuler
from sdaeverify import (
    SDE,
    Array,
    Claim,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Langevin,
    Parts,
    Scheme,
    Step,
)

ADDITIVE = frozenset({"additive-noise"})
TWO = (
    Claim(measure="weak", value=2.0, when=ADDITIVE, source="made up"),
    Claim(measure="invariant", value=2.0, when=ADDITIVE, source="made up"),
    Claim(measure="strong", value=1.0, when=ADDITIVE, source="made up"),
)


class Held(NamedTuple):
    """The state, what is remembered of an earlier one, and how many steps were made since then or in all."""

    x: Array
    old: Array
    count: Array


class Remembering(Scheme):
    """Heun's method for additive noise from a drift at a state that is remembered.

    x+ = x + h/2 (f(y) + f(x + h f(x) + S dW)) + S dW.
    """

    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = TWO

    def refuses(self, problem: Any) -> str:
        """Refuse noise that is not additive."""
        return "" if problem.traits >= ADDITIVE else "the noise is not additive"

    def enter(self, problem: Any, state: Array, t: float, h: float) -> Held:
        """Return a state that remembers itself."""
        return Held(state, state, np.zeros((1, state.shape[-1])))

    def parts(self, problem: Any, state: Held) -> Parts:
        """Return x without the memory."""
        named: Parts = problem.parts(state.x)
        return named

    def remembered(self, state: Held, t: float, h: float) -> Array:
        """Return the state whose drift is taken."""
        raise NotImplementedError

    def kept(self, problem: SDE, state: Held, t: float, h: float) -> Array:
        """Return what is remembered from now on."""
        return self.remembered(state, t, h)

    def step(self, problem: SDE, state: Held, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, _, count = state
        kick = problem.diffused(t, x, noise.dW)
        f, old = problem.drift(t, x), problem.drift(t, self.remembered(state, t, h))
        new = x + 0.5 * h * (old + problem.drift(t + h, x + h * f + kick)) + kick
        return Step(Held(new, self.kept(problem, state, t, h), count + 1.0))


@dataclass(frozen=True)
class EverySoMany(Remembering):
    """The drift of the state at the last of every `period` steps, or of every ceil(h^(-power)/2)."""

    period: int = 2
    power: float = 0.0

    name: ClassVar[str] = "every-so-many"

    def remembered(self, state: Held, t: float, h: float) -> Array:
        """Return the state at the last step that renewed it."""
        period = ceil(0.5 * h**-self.power) if self.power else self.period
        return np.where(state.count % period == 0, state.x, state.old)


@dataclass(frozen=True)
class SetsIn(Remembering):
    """The drift of the step before from a number of steps on, or from a time on."""

    steps: int = 0
    time: float = 0.0

    name: ClassVar[str] = "sets-in"

    def remembered(self, state: Held, t: float, h: float) -> Array:
        """Return the state before, late enough."""
        return np.where((state.count > self.steps) & (t >= self.time), state.old, state.x)

    def kept(self, problem: SDE, state: Held, t: float, h: float) -> Array:
        """Return the present state."""
        return state.x


@dataclass(frozen=True)
class RunningMean(Remembering):
    """The drift of a running mean, of which each step renews a part."""

    part: float = 0.6

    name: ClassVar[str] = "running-mean"

    def remembered(self, state: Held, t: float, h: float) -> Array:
        """Return the mean, x included."""
        return self.part * state.x + (1.0 - self.part) * state.old


@dataclass(frozen=True)
class OldNoise(Remembering):
    """Heun's method whose predictor adds a part of the increment of the step before."""

    part: float = 0.5

    name: ClassVar[str] = "old-noise"

    def enter(self, problem: Any, state: Array, t: float, h: float) -> Held:
        """Return a state before which there was no increment."""
        return Held(state, 0.0 * state, np.zeros((1, state.shape[-1])))

    def step(self, problem: SDE, state: Held, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, old, count = state
        kick = problem.diffused(t, x, noise.dW)
        f = problem.drift(t, x)
        new = x + 0.5 * h * (f + problem.drift(t + h, x + h * f + kick + self.part * old)) + kick
        return Step(Held(new, kick, count + 1.0))


@dataclass(frozen=True)
class AdamsBashforth(Remembering):
    """x+ = x + h (3 f_n - f_{n-1})/2 + S dW, right, with a first step of Euler's: order 2 without noise."""

    name: ClassVar[str] = "adams-bashforth"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, when=ADDITIVE, source="Buckwar & Winkler 2006"),
        Claim(measure="strong", value=1.0, when=ADDITIVE, source="Buckwar & Winkler 2006"),
    )

    def step(self, problem: SDE, state: Held, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, old, count = state
        f, before = problem.drift(t, x), problem.drift(t - h, old)
        new = x + h * (1.5 * f - 0.5 * np.where(count > 0, before, f)) + problem.diffused(t, x, noise.dW)
        return Step(Held(new, x, count + 1.0))


class HeldForce(NamedTuple):
    """Position and momentum, the position of the force, and a number of steps."""

    x: Array
    old: Array
    count: Array


@dataclass(frozen=True)
class OldForce(Scheme):
    """BAOAB whose first kick takes the force of the last even step, or of the step before."""

    period: int = 2

    name: ClassVar[str] = "old-force"
    form: ClassVar[type[Langevin]] = Langevin
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="made up"),
        Claim(measure="weak", value=2.0, source="made up"),
        Claim(measure="invariant", value=2.0, source="made up"),
    )

    def enter(self, problem: Langevin, state: Array, t: float, h: float) -> HeldForce:
        """Return a state that remembers its position."""
        return HeldForce(state, state[: problem.noise_dim], np.zeros((1, state.shape[-1])))

    def parts(self, problem: Langevin, state: HeldForce) -> Parts:
        """Return position and momentum."""
        return problem.parts(state.x)

    def step(self, problem: Langevin, state: HeldForce, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        q, p = state.x[:n], state.x[n:]
        old = np.where(state.count % self.period == 0, q, state.old)
        variance = -np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma > 0.0 else h
        p = p + 0.5 * h * problem.force(old)
        middle = np.exp(-gamma * h) * p + problem.strength * np.sqrt(variance / h) * noise.dW
        q = q + 0.5 * h * (p + middle)
        return Step(HeldForce(np.concatenate([q, middle + 0.5 * h * problem.force(q)]), old, state.count + 1.0))


class HeldDrift(NamedTuple):
    """A state of mechanics, the velocity of the drift, and a number of steps."""

    r: Array
    v: Array
    mu: Array
    old: Array
    count: Array


@dataclass(frozen=True)
class OldDrift(HalfExplicitEuler):
    """Half-explicit Euler without truncation, with the force of the state ceil(h^(-power)/2) steps ago at most."""

    power: float = 1.0 / 3.0

    name: ClassVar[str] = "old-drift"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, when=frozenset({"vanishing-milstein-term"}), source="made up"),
        Claim(measure="weak", value=1.0, source="made up"),
    )

    @property
    def promises(self) -> tuple[Claim, ...]:
        """The orders alone."""
        return self.claims

    def enter(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float) -> HeldDrift:
        """Return a state that remembers itself."""
        return HeldDrift(*state, np.concatenate([state.r, state.v]), np.zeros((1, state.r.shape[-1])))

    def parts(self, problem: HolonomicSDAE, state: HeldDrift) -> Parts:
        """Return position, velocity and multiplier."""
        return problem.parts(HolonomicState(*state[:3]))

    def step(self, problem: HolonomicSDAE, state: HeldDrift, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        now = np.concatenate([state.r, state.v])
        old = np.where(state.count % ceil(0.5 * h**-self.power) == 0, now, state.old)
        r, v = np.split(old, 2)
        lagged = problem.force(t, r, v) - problem.force(t, state.r, state.v)
        moved = state.v + problem.inverse_mass(h * lagged)
        made = super().step(problem, HolonomicState(state.r, moved, state.mu), t, h, noise)
        return made._replace(state=HeldDrift(*made.state, old, state.count + 1.0))
