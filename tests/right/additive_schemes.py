"""Schemes for additive noise: Runge-Kutta steps with the time integral of the noise, splittings, extrapolation."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from right.case import ADDITIVE, ONE, SECOND, Case, Twin, needs, order, runge_kutta
from sdaeverify import SDE, TWO_POINT, Array, Claim, Increment, Law, Parts, Step

THREE_HALVES = order("strong", 1.5), order("weak", 2.0)
SPACE_TIME = frozenset({"dW", "H"})


class ForAdditive(Twin):
    """A scheme for additive noise."""

    def refuses(self, problem: SDE) -> str:
        """Refuse other noise."""
        return needs(problem, *ADDITIVE)


@dataclass(frozen=True)
class ShiftedEuler(ForAdditive):
    """x+ = x + h f(t + h/2, x + S Z/h) + S dW, Z = int W ds; wrong with S H added."""

    name: ClassVar[str] = "right-shifted-euler"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        x, mean = state, noise.time_integral(h) / h
        f = problem.drift(t + 0.5 * h, x + problem.diffused(t, x, mean))
        return Step(x + h * f + problem.diffused(t, x, noise.dW + self.weight(0.0, 1.0) * noise.H))


@dataclass(frozen=True)
class ShARK(ForAdditive):
    """y = x + S H, z = y + (5/6) (h f(y) + S dW), x+ = x + h (2 f(y) + 3 f(z))/5 + S dW; wrong with 2/3 for 5/6."""

    name: ClassVar[str] = "right-shark"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = THREE_HALVES

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        x, c, kick = state, self.weight(5.0 / 6.0, 2.0 / 3.0), problem.diffused(t, state, noise.dW)
        y = x + problem.diffused(t, x, noise.H)
        f = problem.drift(t, y)
        later = problem.drift(t + c * h, y + c * (h * f + kick))
        return Step(x + h * (0.4 * f + 0.6 * later) + kick)


@dataclass(frozen=True)
class SRA3(ForAdditive):
    """Three stages, x+ = x + h (f_1 + f_2 + 4 f_3)/6 + S dW; wrong with 1 for the 3/2 in the third stage.

    f_2 = f(t + h, x + h f_1),  f_3 = f(t + h/2, x + h (f_1 + f_2)/4 + (3/2) S Z/h).
    """

    name: ClassVar[str] = "right-sra3"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = THREE_HALVES

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, part = state, self.weight(1.5, 1.0) * problem.diffused(t, state, noise.time_integral(h) / h)
        first = problem.drift(t, x)
        second = problem.drift(t + h, x + h * first)
        third = problem.drift(t + 0.5 * h, x + 0.25 * h * (first + second) + part)
        return Step(x + h * (first + second + 4.0 * third) / 6.0 + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class StrangAdditive(ForAdditive):
    """Half the flow of f, S dW, half the flow of f; wrong with the whole flow before the noise."""

    name: ClassVar[str] = "right-strang-additive"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""

        def moved(s: float, x: Array) -> Array:
            return runge_kutta(lambda y: 0.5 * h * problem.drift(s, y), x)

        x, kick = moved(t + 0.25 * h, state), problem.diffused(t, state, noise.dW)
        if self.right:
            return Step(moved(t + 0.75 * h, x + kick))
        return Step(moved(t + 0.75 * h, x) + kick)


@dataclass(frozen=True)
class NoiseOutside(ForAdditive):
    """S dW/2, the flow of f, S dW/2, with two halves of the noise; wrong with 0.4 and 0.6 of it."""

    name: ClassVar[str] = "right-noise-outside"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        a = self.weight(0.5, 0.4)
        # Independent, of variances a h and (1 - a) h.
        part = a * noise.dW + np.sqrt(12.0 * a * (1.0 - a)) * noise.H
        x = state + problem.diffused(t, state, part)
        x = runge_kutta(lambda y: h * problem.drift(t + 0.5 * h, y), x)
        return Step(x + problem.diffused(t, state, noise.dW - part))


@dataclass(frozen=True)
class Extrapolated(ForAdditive):
    """Twice two half steps of Euler's, minus one step; wrong with 1.9 and 0.9."""

    name: ClassVar[str] = "right-extrapolated"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        x, f, twice = state, problem.drift(t, state), self.weight(2.0, 1.9)
        early = problem.diffused(t, x, 0.5 * noise.dW + np.sqrt(3.0) * noise.H)
        later = problem.drift(t + 0.5 * h, x + 0.5 * h * f + early)
        two = 0.5 * h * (f + later)
        return Step(x + twice * two + (1.0 - twice) * h * f + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class HeunTwoPoint(ForAdditive):
    """Heun's step for additive noise with two-point variables: weak order 1 alone; wrong with 0.9 of the noise."""

    name: ClassVar[str] = "right-heun-two-point"
    law: ClassVar[Law] = TWO_POINT
    claims: ClassVar[tuple[Claim, ...]] = (order("weak", 1.0),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f, kick = state, problem.drift(t, state), problem.diffused(t, state, noise.dW)
        later = problem.drift(t + h, x + h * f + kick)
        return Step(x + 0.5 * h * (f + later) + self.weight(1.0, 0.9) * kick)


class Averaged(NamedTuple):
    """A state and the increment of the step before."""

    x: Array
    dW: Array


@dataclass(frozen=True)
class LeimkuhlerMatthews(ForAdditive):
    """x+ = x + h f(x) + S (dW_{n-1} + dW_n)/2: invariant order 2; wrong with 0.6 and 0.4."""

    name: ClassVar[str] = "right-leimkuhler-matthews"
    claims: ClassVar[tuple[Claim, ...]] = (order("invariant", 2.0, "overdamped-gradient"),)

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Averaged:
        """Return a state without an increment before it."""
        return Averaged(state, np.zeros((problem.noise_dim, state.shape[1])))

    def parts(self, problem: SDE, state: Averaged) -> Parts:
        """Return the components of x."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Averaged, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, old), a = state, self.weight(0.5, 0.6)
        mean = a * old + (1.0 - a) * noise.dW
        new = x + h * problem.drift(t, x) + problem.diffused(t, x, mean)
        return Step(Averaged(new, noise.dW.copy()))


@dataclass(frozen=True)
class SkewSymmetric(ForAdditive):
    """x+ = x +- S dW with the probability 1/(1 + exp(-+2 f S dW/S^2)) of each sign; wrong with 1 for 2.

    E[+-S dW] = E[S dW tanh(f S dW/S^2)] = h f + O(h^2): weak order 1, with no drift added.
    """

    name: ClassVar[str] = "right-skew-symmetric"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (order("weak", 1.0),)

    def refuses(self, problem: SDE) -> str:
        """Refuse several components, and none of noise."""
        if problem.noise_dim == 1 == problem.dimension and not np.any(problem.diffusion(0.0, problem.initial(1))):
            return "there is no noise"
        return super().refuses(problem) or needs(problem, "scalar-noise", components=1)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, S = state, problem.diffusion(t, state)[:, 0]
        kick = S * noise.dW
        up = 1.0 / (1.0 + np.exp(-self.weight(2.0, 1.0) * problem.drift(t, x) * kick / S**2))
        return Step(x + np.where(noise.uniform(h) < up, kick, -kick))


CASES = (
    Case(ShiftedEuler, "ou,double-well"),
    Case(ShARK, "ou,forced-ou"),
    Case(SRA3, "ou,forced-ou"),
    Case(StrangAdditive, "ou,forced-ou"),
    Case(NoiseOutside, "ou,forced-ou"),
    Case(Extrapolated, "ou,forced-ou"),
    Case(HeunTwoPoint, "ou,forced-ou"),
    Case(LeimkuhlerMatthews, "double-well"),
    Case(SkewSymmetric, "ou"),
)
