"""Schemes of higher order for SDEs with a wrong term, variable or supporting value."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, THREE_POINT, TWO_POINT, Array, Claim, Increment, Law, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1, stages

from ._other_noise import OtherNoise

# Milstein's scheme for one Brownian motion with a wrong correction, and the claim of Milstein's order.


@dataclass(frozen=True)
class ScaledCorrection(Milstein):
    """x+ = x + f h + B dW + factor DB B (dW^2 - h), where Milstein's factor is 1/2."""

    factor: float = 1.0

    name: ClassVar[str] = "planted-milstein-factor"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        euler = problem.euler(t, state, h, noise)
        correction = super().step(problem, state, t, h, noise).state - euler
        return Step(euler + 2.0 * self.factor * correction)


class WithoutH(Milstein):
    """Correction (1/2) DB B dW^2, with mean (h/2) DB B."""

    name: ClassVar[str] = "planted-milstein-without-h"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        missing = 0.5 * h * problem.derivative_of_diffusion(t, state, problem.diffusion(t, state)[:, 0])[:, 0]
        return Step(super().step(problem, state, t, h, noise).state + missing)


class WithoutDerivative(Milstein):
    """Correction (1/2) B (dW^2 - h): b in place of b b'."""

    name: ClassVar[str] = "planted-milstein-without-derivative"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        B = problem.diffusion(t, state)
        return Step(problem.euler(t, state, h, noise) + 0.5 * B[:, 0] * (noise.dW**2 - h))


# Platen's scheme with wrong variables or supporting values, and the claim of weak order 2.


# P(|N| <= QUANTILE) = 3/4 for a standard normal N.
QUANTILE = 1.1503493803760079


def heavy(x: Array) -> Array:
    """Return 2 sign(x) if |x| exceeds its upper quartile and 0 otherwise: variance 1 and fourth moment 4."""
    return 2.0 * np.sign(x) * (np.abs(x) > QUANTILE)


class HeavyLaw(PlatenWeak2):
    """A three-point law of variance 1 with fourth moment 4 instead of 3."""

    name: ClassVar[str] = "planted-platen-fourth-moment"
    law: ClassVar[Law] = Law("three-point of fourth moment 4", heavy, (-2.0, 0.0, 2.0), (1 / 8, 3 / 4, 1 / 8))


class TwoPointLaw(PlatenWeak2):
    """Variables +-sqrt(h), with fourth moment h^2."""

    name: ClassVar[str] = "planted-platen-two-point"
    law: ClassVar[Law] = TWO_POINT


@dataclass(frozen=True)
class WrongSupport(PlatenWeak2):
    """Supporting values y_+- = x + a h f +- s sqrt(h) B and y = x + a h f + B dW, for one Brownian motion.

    Attributes
    ----------
    s, a : float
        Factors of the spread and of the drift; 1 is right for both.
    """

    s: float = 1.0
    a: float = 1.0

    name: ClassVar[str] = "planted-platen-support"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, dW = state, noise.dW
        f, B = problem.drift(t, x), problem.diffusion(t, x)
        centre, spread = x + self.a * h * f, self.s * np.sqrt(h) * B[:, 0]
        up, down = problem.diffusion(t + h, centre + spread), problem.diffusion(t + h, centre - spread)
        drift = 0.5 * h * (f + problem.drift(t + h, centre + apply(B, dW)))
        kick = 0.25 * (apply(up + down + 2.0 * B, dW) + apply(up - down, dW * dW - h) / np.sqrt(h))
        return Step(x + drift + kick)


# Platen's scheme for several noises with a wrong double integral, and the claim of weak order 2.


class OtherSigns(OtherNoise, PlatenWeak2General):
    """Changed signs V_rj, by changes of H, from which the scheme derives them."""

    name: ClassVar[str] = "planted-platen-general-signs"


class FewSigns(PlatenWeak2General):
    """The sign of the fourth Brownian motion is the product of the first three: wrong from four motions on."""

    name: ClassVar[str] = "planted-platen-general-few-signs"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        signs = noise.H.copy()
        signs[3:] = signs[:3].prod(axis=0) * (12.0 / h)
        return super().step(problem, state, t, h, noise._replace(H=signs))


# The same with a coefficient at the wrong time: no effect on autonomous equations, where f(t) and b(t) vanish.


class OldDrift(PlatenWeak2General):
    """The drift of the second stage is taken at t instead of t + h."""

    name: ClassVar[str] = "planted-platen-general-old-drift"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        held = replace(problem, drift=lambda _, x: problem.drift(t, x))
        return super().step(held, state, t, h, noise)


class OldNoise(PlatenWeak2General):
    """B(y_j+-) is taken at t instead of t + h."""

    name: ClassVar[str] = "planted-platen-general-old-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        held = replace(problem, diffusion=lambda _, x: problem.diffusion(t, x), diffusion_derivative=None)
        return super().step(held, state, t, h, noise)


class NewNoise(PlatenWeak2General):
    """B(u_r+-) is taken at t + h instead of t, as B(y_j+-); B(x) is not."""

    name: ClassVar[str] = "planted-platen-general-new-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""

        def diffusion(_: float, x: Array) -> Array:
            return problem.diffusion(t if x is state else t + h, x)

        held = replace(problem, diffusion=diffusion, diffusion_derivative=None)
        return super().step(held, state, t, h, noise)


# Milstein's scheme with Levy areas of the wrong pairs, and the claim of strong order 1.


class SwappedPairs(MilsteinAreas):
    """Areas of the pairs in reverse order: wrong from three motions on."""

    name: ClassVar[str] = "planted-milstein-areas-pairs"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.A is not None
        return super().step(problem, state, t, h, noise._replace(A=noise.A[::-1]))


# SRA1 with a wrong time integral Z of the noise, and the claim of strong order 3/2.


class OtherArea(OtherNoise, SRA1):
    """Changed time integral Z/h = dW/2 + H, by changes of H."""

    name: ClassVar[str] = "planted-sra1-area"


class AreaForIntegral(SRA1):
    """H in place of Z/h = H + dW/2."""

    name: ClassVar[str] = "planted-sra1-area-for-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, _OnlyArea(*noise))


class _OnlyArea(Increment):
    """An increment whose time integral lacks the part of dW."""

    __slots__ = ()

    def time_integral(self, h: float) -> Array:
        """Return h H, shape (l, P)."""
        assert self.H is not None
        return h * self.H


@dataclass(frozen=True)
class WeakSRA1(SRA1):
    """SRA1 with signs instead of normal H, and the claim of weak order 2, right with a sign for each motion.

    Attributes
    ----------
    one : bool
        Whether the sign of the first Brownian motion is used for all.
    """

    one: bool = True

    name: ClassVar[str] = "planted-sra1-one-sign"
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, source="Roessler 2010, with signs for H"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        H = np.repeat(noise.H[:1], len(noise.H), axis=0) if self.one else noise.H
        return super().step(problem, state, t, h, noise._replace(H=H))


# SRI1W1 with a wrong integral of the noise or a wrong stage, and the claim of strong order 3/2.


class OtherIntegral(OtherNoise, SRI1W1):
    """Z = h (dW/2 + H) with another H, the part of int W ds independent of dW."""

    name: ClassVar[str] = "planted-sri1w1-area"


class WithoutTripleIntegral(SRI1W1):
    """The term with I_111 is missing."""

    name: ClassVar[str] = "planted-sri1w1-without-triple-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        *_, thrice = stages(problem, state, t, h, problem.drift(t, state))
        dW = noise.dW
        return Step(super().step(problem, state, t, h, noise).state - thrice * (dW**3 - 3.0 * h * dW) / (6.0 * h))


class StratonovichIntegral(SRI1W1):
    """The double integral is dW^2/2 instead of (dW^2 - h)/2."""

    name: ClassVar[str] = "planted-sri1w1-stratonovich-integral"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        _, _, twice, _ = stages(problem, state, t, h, problem.drift(t, state))
        return Step(super().step(problem, state, t, h, noise).state + 0.5 * np.sqrt(h) * twice)


class OldTimes(SRI1W1):
    """All stages use the coefficients at the beginning of the step."""

    name: ClassVar[str] = "planted-sri1w1-old-times"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        held = replace(
            problem,
            drift=lambda _, x: problem.drift(t, x),
            diffusion=lambda _, x: problem.diffusion(t, x),
            diffusion_derivative=None,
        )
        return super().step(held, state, t, h, noise)


BUGS = [
    Planted("Milstein: without -h", WithoutH(), "gbm"),
    Planted("Milstein: correction sign", ScaledCorrection(-0.5), "gbm"),
    Planted("Milstein: factor 1 instead of 1/2", ScaledCorrection(), "gbm"),
    Planted("Milstein: factor .45", ScaledCorrection(0.45), "gbm"),
    Planted("Milstein: b instead of b b'", WithoutDerivative(), "gbm"),
    Planted("Platen: support +5 %", WrongSupport(1.05), "gbm"),
    Planted("Platen: wrong 4th moment", HeavyLaw(), "gbm"),
    Planted("Platen: two-point variables", TwoPointLaw(), "gbm"),
    Planted("Platen: predictor without drift", WrongSupport(a=0.0), "gbm"),
    Planted("Platen-2, general: without signs", OtherSigns(H="none"), "noncommuting"),
    Planted("Platen-2, general: signs 10 % too small", OtherSigns(H="0.9"), "noncommuting"),
    Planted("Platen-2, general: one sign for all", OtherSigns(H="first"), "noncommuting"),
    Planted("Platen-2, general: three signs for four motions", FewSigns(), "four-motions"),
    Planted("Platen-2, general: drift at the old time", OldDrift(), "turning-frame"),
    # On these problems the relevant elementary differentials vanish, so that only order conditions refute it.
    Planted("Platen-2, general: drift at the old time, unseen", OldDrift(), "noncommuting"),
    Planted("Platen-2, general: noise at the old time, unseen", OldNoise(), "levy-area"),
    Planted("Platen-2, general: noise of y at the old time", OldNoise(), "turning-frame"),
    Planted("Platen-2, general: noise of u at the new time", NewNoise(), "turning-frame"),
    Planted("Milstein with areas: areas of other pairs", SwappedPairs(), "three-motions"),
    Planted("SRA1, weak: one sign for all", WeakSRA1(), "product-force"),
    Planted(
        "SRA1, weak: signs for normal H",
        WeakSRA1(one=False),
        "product-force",
        equivalent="weak order 2 asks for the mean, the variance and the correlation of H alone",
    ),
    Planted("SRA1: H for Z/h", AreaForIntegral(), "double-well"),
    Planted("SRA1: H doubled", OtherArea(H="doubled"), "double-well"),
    Planted("SRA1: H sign", OtherArea(H="negative"), "double-well"),
    Planted("SRI1W1: H left out", OtherIntegral(H="none"), "hyperbolic"),
    Planted("SRI1W1: H of the first motion for all", OtherIntegral(H="first"), "hyperbolic-pair"),
    Planted("SRI1W1: I_111 left out", WithoutTripleIntegral(), "spiral"),
    Planted("SRI1W1: Stratonovich's double integral", StratonovichIntegral(), "hyperbolic"),
    Planted("SRI1W1: stages at the old time", OldTimes(), "growing-volatility"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
