"""Euler-Maruyama with the noises of a system mixed up, and orders that need iterated integrals it leaves out."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Step, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama, TamedEuler

ORDER_ONE = (Claim(measure="strong", value=1.0, source="planted"), Claim(measure="weak", value=1.0, source="planted"))


class SwappedColumns(EulerMaruyama):
    """Each column of B gets the increment of another one: of the right law, on the wrong path."""

    name: ClassVar[str] = "planted-em-swapped-noises"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=noise.dW[::-1]))


class OneNoiseForAll(EulerMaruyama):
    """All columns of B get the first increment."""

    name: ClassVar[str] = "planted-em-one-noise"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.broadcast_to(noise.dW[:1], noise.dW.shape)))


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
    """Milstein's terms DB_j B_j (dW_j^2 - h)/2 alone, where noises do not commute; it claims Milstein's order."""

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
    """Taming f/(1 + sqrt(h) |f|), which costs half an order of the drift."""

    name: ClassVar[str] = "planted-tamed-by-sqrt-h"
    claims: ClassVar[tuple[Claim, ...]] = ORDER_ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        f = problem.drift(t, state)
        tamed = h * f / (1.0 + np.sqrt(h) * np.sqrt((f * f).sum(axis=0)))
        return Step(state + tamed + apply(problem.diffusion(t, state), noise.dW))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    swapped = Planted(bug="EM: noises swapped", scheme=SwappedColumns(), problem="noncommuting")
    return [
        swapped,
        replace(swapped, bug="EM: one noise for all columns", scheme=OneNoiseForAll()),
        replace(swapped, bug="EM: diffusion matrix transposed", scheme=TransposedDiffusion()),
        replace(swapped, bug="Milstein: cross terms missing, noises do not commute", scheme=DiagonalMilstein()),
        Planted(bug="EM: Milstein's order claimed", scheme=EulerAsMilstein(), problem="gbm"),
        Planted(bug="tamed Euler: sqrt(h) |f| in place of h |f|", scheme=TamedTooMuch(), problem="double-well"),
    ]
