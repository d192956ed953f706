"""Euler's and Heun's methods with wrong coefficients, noise or claims, and the claims of the right methods."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Problem, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama, TamedEuler
from sdaeverify_schemes.heun import Heun, HeunAdditive, stratonovich
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas

from ._other_noise import OtherNoise
from ._within import ScaledEuler

# Euler-Maruyama with wrong noise, wrong drift or a wrong limit, and the claims of Euler-Maruyama.


class WithoutItoCorrection(EulerMaruyama):
    """x+ = x + (f - (1/2) sum_j DB_j B_j) h + B dW: Ito's integral with the Stratonovich drift."""

    name: ClassVar[str] = "planted-em-stratonovich-drift"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        F, B = stratonovich(problem, t, state)
        return Step(state + h * F + apply(B, noise.dW))


class HeunOfItoDrift(Heun):
    """Heun's scheme with Ito's drift f, which converges to the Stratonovich solution for the same coefficients."""

    name: ClassVar[str] = "planted-heun-ito-drift"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        y = state + h * f + apply(B, noise.dW)
        both = apply(B, noise.dW) + apply(problem.diffusion(t + h, y), noise.dW)
        return Step(state + 0.5 * (h * (f + problem.drift(t + h, y)) + both))


@dataclass(frozen=True)
class WrongVariance(EulerMaruyama):
    """Noise of variance (1 + excess) h."""

    excess: float = 0.05

    name: ClassVar[str] = "planted-em-variance"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(1.0 + self.excess) * noise.dW))


class OtherNoiseEuler(OtherNoise, EulerMaruyama):
    """Euler-Maruyama with a changed increment, for example h xi in place of sqrt(h) xi."""

    name: ClassVar[str] = "planted-em-noise"


class ImplicitNoise(EulerMaruyama):
    """Theta = 1/2 in the noise as well: x+ = x + f h + (1/2) [B(x) + B(y)] dW with y = x + f h + B dW."""

    name: ClassVar[str] = "planted-em-theta-in-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        y = super().step(problem, state, t, h, noise).state
        change = apply(problem.diffusion(t + h, y) - problem.diffusion(t, state), noise.dW)
        return Step(y + 0.5 * change)


# Euler-Maruyama with mixed-up noises of a system, and claims of orders that need the omitted iterated integrals.


ORDER_ONE = (Claim(measure="strong", value=1.0, source="planted"), Claim(measure="weak", value=1.0, source="planted"))


class TransposedDiffusion(EulerMaruyama):
    """x+ = x + f h + B^T dW for a square B."""

    name: ClassVar[str] = "planted-em-transposed-diffusion"

    def refuses(self, problem: SDE) -> str:
        """Refuse a B that is not square."""
        return "" if problem.noise_dim == problem.dimension else "B is not square"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        B = problem.diffusion(t, state)
        return Step(state + h * problem.drift(t, state) + apply(np.swapaxes(B, 0, 1), noise.dW))


class DiagonalMilstein(EulerMaruyama):
    """Only Milstein's terms DB_j B_j (dW_j^2 - h)/2 for noncommutative noise, with the claim of Milstein's order."""

    name: ClassVar[str] = "planted-milstein-no-cross-terms"
    claims: ClassVar[tuple[Claim, ...]] = ORDER_ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        B = problem.diffusion(t, state)
        terms = [
            0.5 * problem.derivative_of_diffusion(t, state, B[:, j])[:, j] * (noise.dW[j] ** 2 - h)
            for j in range(problem.noise_dim)
        ]
        return Step(super().step(problem, state, t, h, noise).state + sum(terms))


class EulerAsMilstein(EulerMaruyama):
    """Euler-Maruyama that claims Milstein's order."""

    name: ClassVar[str] = "planted-em-claims-order-1"
    claims: ClassVar[tuple[Claim, ...]] = ORDER_ONE


class TamedTooMuch(TamedEuler):
    """Taming f/(1 + sqrt(h) |f|), which loses half an order of the drift."""

    name: ClassVar[str] = "planted-tamed-by-sqrt-h"
    claims: ClassVar[tuple[Claim, ...]] = ORDER_ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f = problem.drift(t, state)
        tamed = h * f / (1.0 + np.sqrt(h) * np.sqrt((f * f).sum(axis=0)))
        return Step(state + tamed + apply(problem.diffusion(t, state), noise.dW))


# Euler-Maruyama with coefficients at wrong states: exact for constant coefficients, otherwise inconsistent.


@dataclass(frozen=True)
class WrongTimes(EulerMaruyama):
    """x+ = x + h f(c t + d h, x) + B(t, x) dW.

    Attributes
    ----------
    c, d : float
        Factors of t and h; 1 and 0 are right.
    """

    c: float = 1.0
    d: float = 0.0

    name: ClassVar[str] = "planted-em-times"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return Step(state + h * problem.drift(self.c * t + self.d * h, state) + problem.diffused(t, state, noise.dW))


# Schemes that declare jumps or areas, which excludes quadrature nodes, and have an obvious error.


class JumpingEuler(ScaledEuler):
    """x+ = x + h f(t, b x) + B(t, d x) dW that declares steps to jump as functions of their noise.

    With constant coefficients, as in the problems that every scheme solves exactly, b and d have no effect.
    """

    name: ClassVar[str] = "planted-em-jumps"
    discontinuous_in_noise: ClassVar[bool] = True


class AreaEuler(JumpingEuler):
    """The scheme `JumpingEuler` that declares to need areas instead, without using them."""

    name: ClassVar[str] = "planted-em-areas"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})
    discontinuous_in_noise: ClassVar[bool] = False


@dataclass(frozen=True)
class ScaledAreas(MilsteinAreas):
    """Milstein's scheme with scaled areas, or with its drift at a x or its noise at b x.

    Attributes
    ----------
    areas : float
        Factor of the areas.
    of_drift, of_noise : float
        Factors a and b.
    """

    areas: float = 1.02
    of_drift: float = 1.0
    of_noise: float = 1.0

    name: ClassVar[str] = "planted-milstein-areas"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        given = noise if noise.A is None else noise._replace(A=self.areas * noise.A)
        euler = ScaledEuler(of_drift=self.of_drift, of_noise=self.of_noise).step(problem, state, t, h, noise).state
        return Step(super().step(problem, state, t, h, given).state + euler - problem.euler(t, state, h, noise))


# Heun's scheme for additive noise with wrong stages, and the claim of weak order 2.


@dataclass(frozen=True)
class WrongStages(HeunAdditive):
    """x+ = x + h [(1 - w) f(t + a h, x) + w f(t + b h, y)] + B dW with y = x + h f + c B dW.

    Attributes
    ----------
    w, a, b, c : float
        Weight, times and noise factor of the stages; 1/2, 0, 1 and 1 are right.
    """

    w: float = 0.5
    a: float = 0.0
    b: float = 1.0
    c: float = 1.0

    name: ClassVar[str] = "planted-heun-stages"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        kick = apply(problem.diffusion(t, state), noise.dW)
        f = problem.drift(t + self.a * h, state)
        later = problem.drift(t + self.b * h, state + h * f + self.c * kick)
        return Step(state + h * ((1.0 - self.w) * f + self.w * later) + kick)


# Schemes that claim mean-square stability for every step size but are unstable for long steps.


A_STABLE = Claim(measure="stability", value="A-stable", source="planted")


@dataclass(frozen=True)
class AlmostHalf(StochasticTheta):
    """The theta method with theta below 1/2: stable on dx = a x dt + b x dW up to -(2a + b^2)/(a^2 (1 - 2 theta))."""

    theta: float = 0.499

    name: ClassVar[str] = "planted-theta"
    form: ClassVar[tuple[type[Problem], ...]] = (SDE,)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims of the method with theta = 1/2."""
        return (*self.claims, A_STABLE)


class AStableEuler(EulerMaruyama):
    """Euler-Maruyama, stable up to -(2a + b^2)/a^2."""

    name: ClassVar[str] = "planted-em-a-stable"
    claims: ClassVar[tuple[Claim, ...]] = (A_STABLE,)


class AStableMilstein(Milstein):
    """Milstein's scheme, stable up to -(2a + b^2)/(a^2 + b^4/2)."""

    name: ClassVar[str] = "planted-milstein-a-stable"
    claims: ClassVar[tuple[Claim, ...]] = (A_STABLE,)


BUGS = [
    Planted("EM: missing Ito correction", WithoutItoCorrection(), "gbm"),
    Planted("EM: noise variance +5 %", WrongVariance(), "gbm"),
    Planted("EM: noise variance +1 %", WrongVariance(0.01), "gbm"),
    Planted("EM: h instead of sqrt(h) in the noise", OtherNoiseEuler("of size h"), "gbm"),
    Planted("EM: drift x 0.98", ScaledEuler(drift=0.98), "gbm"),
    Planted("EM: theta in the noise as well", ImplicitNoise(), "gbm"),
    Planted("EM: noise clipped at one standard deviation", OtherNoiseEuler("clipped"), "gbm"),
    Planted("Heun: Ito drift in a Stratonovich scheme", HeunOfItoDrift(), "gbm"),
    Planted("EM: noises swapped", OtherNoiseEuler("swapped"), "noncommuting"),
    Planted("EM: one noise for all columns", OtherNoiseEuler("first"), "noncommuting"),
    Planted("EM: diffusion matrix transposed", TransposedDiffusion(), "noncommuting"),
    Planted("Milstein: cross terms missing, noises do not commute", DiagonalMilstein(), "noncommuting"),
    Planted("EM: Milstein's order claimed", EulerAsMilstein(), "gbm"),
    Planted("tamed Euler: sqrt(h) |f| in place of h |f|", TamedTooMuch(), "double-well"),
    Planted("EM: drift at 0.98 x", ScaledEuler(of_drift=0.98), "gbm"),
    Planted("EM: diffusion at 1.005 x", ScaledEuler(of_noise=1.005), "gbm"),
    Planted("EM: drift always at time 0", WrongTimes(c=0.0), "forced-ou"),
    Planted(
        "EM: drift at the end of the step",
        WrongTimes(d=1.0),
        "forced-ou",
        equivalent="a change of size h^2 of the step, which Euler-Maruyama has an error of anyway",
    ),
    Planted("EM, declares jumps: noise at 1.003 x", JumpingEuler(of_noise=1.003), "gbm"),
    Planted("EM, declares jumps: drift at 0.98 x", JumpingEuler(of_drift=0.98), "gbm"),
    Planted("EM, declares jumps: drift at 0.98 x, to rest", JumpingEuler(of_drift=0.98), "ou"),
    Planted("EM, declares areas: noise at 1.003 x", AreaEuler(of_noise=1.003), "levy-area"),
    Planted("EM, declares areas: drift at 0.98 x", AreaEuler(of_drift=0.98), "levy-area"),
    Planted("Milstein with areas: areas x 1.02", ScaledAreas(), "levy-area"),
    Planted("Milstein with areas: areas x 0.9", ScaledAreas(0.9), "levy-area"),
    Planted("Milstein with areas: noise at 1.003 x", ScaledAreas(1.0, of_noise=1.003), "levy-area"),
    Planted("Milstein with areas: drift at 0.98 x", ScaledAreas(1.0, 0.98), "levy-area"),
    Planted("Heun: stage at wrong time", WrongStages(b=0.0), "forced-ou"),
    Planted("Heun: predictor without noise", WrongStages(c=0.0), "double-well"),
    Planted("Heun: weights .55/.45", WrongStages(0.45), "double-well"),
    Planted(
        "Heun: both stages at t + h/2",
        WrongStages(a=0.5, b=0.5),
        "forced-ou",
        equivalent="a midpoint rule in time, of order 2 like the trapezoidal one",
    ),
    Planted("theta = .499: A-stability claimed", AlmostHalf(), "linear-test[a=-10,b=2]"),
    Planted("theta = .49: A-stability claimed", AlmostHalf(0.49), "linear-test[a=-10,b=2]"),
    Planted("Euler-Maruyama: A-stability claimed", AStableEuler(), "linear-test[a=-10,b=2]"),
    Planted("Milstein: A-stability claimed", AStableMilstein(), "linear-test[a=-10,b=2]"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
