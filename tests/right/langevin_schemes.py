"""Splittings and other thermostats for Langevin dynamics."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from right.case import ONE, Case, Twin, order
from sdaeverify import Array, Claim, Increment, Langevin, Step

SECOND = order("strong", 1.0), order("weak", 2.0), order("invariant", 2.0)
SPACE_TIME = frozenset({"dW", "H"})


def halves(noise: Increment) -> tuple[Array, Array]:
    """Return two independent variables of variance h/2 whose sum is dW."""
    assert noise.H is not None
    first = 0.5 * noise.dW + np.sqrt(3.0) * noise.H
    return first, noise.dW - first


@dataclass(frozen=True)
class ForLangevin(Twin):
    """A scheme for Langevin dynamics from its parts A (move), B (kick) and O (friction and noise)."""

    form: ClassVar[type] = Langevin

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n = problem.noise_dim
        q, p = self.moved(problem, (state[:n], state[n:]), h, noise)
        return Step(np.concatenate([q, p]))

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        raise NotImplementedError


def thermalised(problem: Langevin, p: Array, h: float, dW: Array) -> Array:
    """Return p after friction and noise alone during h, with dW of variance h."""
    gamma = problem.friction
    variance = -np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma else h
    return np.asarray(np.exp(-gamma * h) * p + problem.strength * np.sqrt(variance / h) * dW)


@dataclass(frozen=True)
class OBABO(ForLangevin):
    """Half of O, half of B, A, half of B, half of O; wrong with 0.4 and 0.6 of B."""

    name: ClassVar[str] = "right-obabo"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        (q, p), (early, late), b = at, halves(noise), self.weight(0.5, 0.4)
        p = thermalised(problem, p, 0.5 * h, early) + b * h * problem.force(q)
        q = q + h * p
        return q, thermalised(problem, p + (1.0 - b) * h * problem.force(q), 0.5 * h, late)


@dataclass(frozen=True)
class ABOBA(ForLangevin):
    """Half of A, half of B, O, half of B, half of A; wrong with the force at the start."""

    name: ClassVar[str] = "right-aboba"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        q, p = at
        middle = q + 0.5 * h * p
        F = problem.force(middle if self.right else q)
        p = thermalised(problem, p + 0.5 * h * F, h, noise.dW) + 0.5 * h * F
        return middle + 0.5 * h * p, p


@dataclass(frozen=True)
class OABAO(ForLangevin):
    """Half of O, half of A, B, half of A, half of O; wrong with the noise of O on one side alone."""

    name: ClassVar[str] = "right-oabao"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        (q, p), (early, late) = at, halves(noise)
        p = thermalised(problem, p, 0.5 * h, early if self.right else noise.dW)
        q = q + 0.5 * h * p
        p = p + h * problem.force(q)
        return q + 0.5 * h * p, thermalised(problem, p, 0.5 * h, late if self.right else 0.0 * late)


@dataclass(frozen=True)
class GLA1(ForLangevin):
    """O, B, A: geometric Langevin of first order; wrong with 0.9 of B."""

    name: ClassVar[str] = "right-gla-1"
    claims: ClassVar[tuple[Claim, ...]] = (*ONE, order("invariant", 1.0))

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        q, p = at
        new = thermalised(problem, p, h, noise.dW) + self.weight(1.0, 0.9) * h * problem.force(q)
        return q + h * new, new


@dataclass(frozen=True)
class GLA2(ForLangevin):
    """O, then half of B, A, half of B: weak order 1, and invariant order 2; wrong with 0.9 of B."""

    name: ClassVar[str] = "right-gla-2"
    claims: ClassVar[tuple[Claim, ...]] = (*ONE, order("invariant", 2.0))

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        q, p = at
        p = thermalised(problem, p, h, noise.dW) + 0.5 * h * problem.force(q)
        q = q + h * p
        return q, p + self.weight(0.5, 0.4) * h * problem.force(q)


@dataclass(frozen=True)
class GronbechJensenFarago(ForLangevin):
    """q+ = q + b h (p + h F/2 + sigma dW/2), p+ = a p + h (a F + F+)/2 + b sigma dW; wrong with h p for b h p.

    With b = 1/(1 + gamma h/2) and a = (1 - gamma h/2) b.
    """

    name: ClassVar[str] = "right-gjf"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        (q, p), F, kick = at, problem.force(at[0]), problem.strength * noise.dW
        b = 1.0 / (1.0 + 0.5 * problem.friction * h)
        a = (1.0 - 0.5 * problem.friction * h) * b
        new = q + self.weight(b, 1.0) * h * p + 0.5 * b * h * (h * F + kick)
        return new, a * p + 0.5 * h * (a * F + problem.force(new)) + b * kick


@dataclass(frozen=True)
class BrungerBrooksKarplus(ForLangevin):
    """Velocity Verlet, explicit in the friction in its first half and implicit in the second; wrong with F for F+."""

    name: ClassVar[str] = "right-bbk"
    noise: ClassVar[frozenset[str]] = SPACE_TIME
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        (q, p), (early, late), half = at, halves(noise), 0.5 * problem.friction * h
        F, sigma = problem.force(q), problem.strength
        middle = (1.0 - half) * p + 0.5 * h * F + sigma * early
        new = q + h * middle
        later = problem.force(new) if self.right else F
        return new, (middle + 0.5 * h * later + sigma * late) / (1.0 + half)


@dataclass(frozen=True)
class StochasticPositionVerlet(ForLangevin):
    """Half of A, the exact p for a constant force, half of A; wrong with h F for (1 - c)/gamma F."""

    name: ClassVar[str] = "right-spv"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        q, p = at
        gamma = problem.friction
        middle = q + 0.5 * h * p
        time = -np.expm1(-gamma * h) / gamma if gamma and self.right else h
        p = thermalised(problem, p, h, noise.dW) + time * problem.force(middle)
        return middle + 0.5 * h * p, p


@dataclass(frozen=True)
class ThreePartKick(ForLangevin):
    """B A B O B A B with kicks of h/6 at both ends and of h/3 before and after O; wrong with 0.3 h after it."""

    name: ClassVar[str] = "right-babobab"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def moved(self, problem: Langevin, at: tuple[Array, Array], h: float, noise: Increment) -> tuple[Array, Array]:
        """Return positions and momenta after a step."""
        kick: Callable[[Array, float], Array] = lambda q, part: part * h * problem.force(q)  # noqa: E731
        q, p = at
        p = p + kick(q, 1.0 / 6.0)
        q = q + 0.5 * h * p
        p = p + kick(q, 1.0 / 3.0)
        p = thermalised(problem, p, h, noise.dW) + kick(q, self.weight(1.0 / 3.0, 0.3))
        q = q + 0.5 * h * p
        return q, p + kick(q, 1.0 / 6.0)


WELLS = "harmonic-langevin,angle-pendulum"
CASES = tuple(
    Case(scheme, WELLS)
    for scheme in (
        OBABO,
        ABOBA,
        OABAO,
        GLA1,
        GLA2,
        GronbechJensenFarago,
        BrungerBrooksKarplus,
        StochasticPositionVerlet,
        ThreePartKick,
    )
)
