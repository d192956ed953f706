"""Schemes that are made for Stratonovich's integral: predictors, flows and splittings."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from right.case import (
    COMMUTATIVE,
    EULER,
    ONE,
    SECOND,
    Case,
    Twin,
    ito_drift,
    needs,
    order,
    runge_kutta,
    stratonovich,
    turned,
)
from sdaeverify import SDE, Array, Claim, Increment, Law, Step
from sdaeverify.numerics import apply


class Differentiable(Twin):
    """A scheme that takes derivatives of the diffusion."""

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions whose derivative cannot be had."""
        return problem.why_not_derivative_of_diffusion()


class OneNoise(Differentiable):
    """The same for one Brownian motion."""

    def refuses(self, problem: SDE) -> str:
        """Refuse several noises."""
        return needs(problem, "scalar-noise") or super().refuses(problem)


@dataclass(frozen=True)
class EulerHeun(Differentiable):
    """x+ = x + h F + (1/2) [B(x) + B(x + B dW)] dW; wrong with half the predictor."""

    name: ClassVar[str] = "right-euler-heun"
    claims: ClassVar[tuple[Claim, ...]] = COMMUTATIVE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, kick = state, problem.diffused(t, state, noise.dW)
        later = problem.diffused(t + h, x + self.weight(1.0, 0.5) * kick, noise.dW)
        return Step(x + h * stratonovich(problem, t, x) + 0.5 * (kick + later))


@dataclass(frozen=True)
class ExplicitMidpoint(Differentiable):
    """y = x + (h F + B dW)/2, x+ = x + h F(y) + B(y) dW; wrong with the whole step in y."""

    name: ClassVar[str] = "right-explicit-midpoint"
    claims: ClassVar[tuple[Claim, ...]] = COMMUTATIVE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        y = x + self.weight(0.5, 1.0) * (h * stratonovich(problem, t, x) + problem.diffused(t, x, noise.dW))
        middle = t + 0.5 * h
        return Step(x + h * stratonovich(problem, middle, y) + problem.diffused(middle, y, noise.dW))


@dataclass(frozen=True)
class Ralston(Differentiable):
    """y = x + (2/3) (h F + B dW), x+ = x + (1/4) (...)(x) + (3/4) (...)(y); wrong with weights 1/2."""

    name: ClassVar[str] = "right-ralston"
    claims: ClassVar[tuple[Claim, ...]] = COMMUTATIVE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, b = state, self.weight(0.75, 0.5)
        first = h * stratonovich(problem, t, x) + problem.diffused(t, x, noise.dW)
        s, y = t + 2.0 * h / 3.0, x + 2.0 / 3.0 * first
        second = h * stratonovich(problem, s, y) + problem.diffused(s, y, noise.dW)
        return Step(x + (1.0 - b) * first + b * second)


@dataclass(frozen=True)
class RungeKuttaFour(Differentiable):
    """The classical Runge-Kutta step with h F + B dW; wrong with weights (1, 1, 1, 0)/3."""

    name: ClassVar[str] = "right-runge-kutta-four"
    claims: ClassVar[tuple[Claim, ...]] = COMMUTATIVE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""

        def change(s: float, x: Array) -> Array:
            return h * stratonovich(problem, s, x) + problem.diffused(s, x, noise.dW)

        x = state
        a = change(t, x)
        b = change(t + 0.5 * h, x + 0.5 * a)
        c = change(t + 0.5 * h, x + 0.5 * b)
        d = change(t + h, x + c)
        whole = (a + 2.0 * b + 2.0 * c + d) / 6.0
        return Step(x + (whole if self.right else (a + b + c) / 3.0))


@dataclass(frozen=True)
class LieSplitting(OneNoise):
    """The flow of B for the time dW, then that of F for the time h; wrong with Ito's drift."""

    name: ClassVar[str] = "right-lie-splitting"
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        y = runge_kutta(lambda x: problem.diffused(t, x, noise.dW), state)
        drift = stratonovich if self.right else ito_drift
        return Step(runge_kutta(lambda x: h * drift(problem, t, x), y))


@dataclass(frozen=True)
class StrangSplitting(OneNoise):
    """Half the flow of F, the flow of B for the time dW, half the flow of F; wrong with both halves at the end."""

    name: ClassVar[str] = "right-strang-splitting"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""

        def moved(s: float, x: Array) -> Array:
            return runge_kutta(lambda y: 0.5 * h * stratonovich(problem, s, y), x)

        early, middle, late = t + 0.25 * h, t + 0.5 * h, t + 0.75 * h
        first = moved(early, state) if self.right else state
        turned_by_noise = runge_kutta(lambda y: problem.diffused(middle, y, noise.dW), first)
        last = moved(late, turned_by_noise)
        return Step(last if self.right else moved(late, last))


@dataclass(frozen=True)
class NinomiyaVictoir(Differentiable):
    """Half the flow of F, the flows of all B_j in an order that a coin decides, half the flow of F.

    Wrong without a coin: with several noises that do not commute the weak order is 1.
    """

    name: ClassVar[str] = "right-ninomiya-victoir"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (order("weak", 2.0),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        motions = range(problem.noise_dim)

        def drifted(s: float, x: Array) -> Array:
            return runge_kutta(lambda y: 0.5 * h * stratonovich(problem, s, y), x)

        def kicked(x: Array, order: list[int]) -> Array:
            for j in order:
                x = runge_kutta(lambda y, j=j: problem.diffusion(t + 0.5 * h, y)[:, j] * noise.dW[j], x)
            return x

        x = drifted(t + 0.25 * h, state)
        forth, back = kicked(x, [*motions]), kicked(x, [*reversed(motions)])
        coin = (noise.H[0] > 0.0) | (not self.right)
        return Step(drifted(t + 0.75 * h, np.where(coin, forth, back)))


@dataclass(frozen=True)
class LogODE(Differentiable):
    """The flow of h F + B dW + sum_{j<k} [B_j, B_k] A_jk at time 1; wrong with the sign of A turned."""

    name: ClassVar[str] = "right-log-ode"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        double = noise.double_integrals(h)
        area = self.weight(0.5, -0.5) * (double - double.swapaxes(0, 1))

        def field(x: Array) -> Array:
            brackets = sum(np.einsum("dkp,kp->dp", c, area[j]) for j, c in enumerate(turned(problem, t, x)))
            return h * stratonovich(problem, t, x) + problem.diffused(t, x, noise.dW) + brackets

        return Step(runge_kutta(field, state))


@dataclass(frozen=True)
class ImplicitMidpoint(Differentiable):
    """x+ = x + h F(m) + B(m) dW, m = (x + x+)/2, with clipped increments; wrong with Ito's drift."""

    name: ClassVar[str] = "right-implicit-midpoint"
    law: ClassVar[Law] = Law.clipped_gaussian(2.0)
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s = state, t + 0.5 * h
        drift = stratonovich if self.right else ito_drift
        new = x
        # The iteration contracts at the step sizes that are used here.
        for _ in range(60):
            m = 0.5 * (x + new)
            new = x + h * drift(problem, s, m) + apply(problem.diffusion(s, m), noise.dW)
        return Step(new)


CASES = (
    Case(EulerHeun, "gbm,noncommuting"),
    Case(ExplicitMidpoint, "gbm,noncommuting"),
    Case(Ralston, "gbm,noncommuting"),
    Case(RungeKuttaFour, "gbm,noncommuting"),
    Case(LieSplitting, "gbm,hyperbolic"),
    Case(StrangSplitting, "gbm,hyperbolic"),
    Case(NinomiyaVictoir, "noncommuting,spiral"),
    Case(LogODE, "levy-area"),
    Case(ImplicitMidpoint, "gbm,spiral"),
)
