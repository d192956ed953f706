"""Wrong sealed solvers: mistakes in the law, in the seed and in the independence of paths.

Each has the claims of the right solver that it is made of. They are registered with the solvers, under names that
begin with ``planted-``, and run only where they are named.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Langevin, hookimpl
from sdaeverify_sealed import Ends, Sealed
from sdaeverify_sealed.solvers import OwnBAOAB, OwnEuler


class Warm(OwnBAOAB):
    """BAOAB at 1.1 times the temperature: sigma sqrt(1.1) in place of sigma."""

    name: ClassVar[str] = "planted-warm"

    def run(self, problem: Langevin, h: float, T: float, paths: int, seed: int) -> Ends:
        """Run the warmer dynamics."""
        return super().run(replace(problem, strength=problem.strength * np.sqrt(1.1)), h, T, paths, seed)


class HalfDrift(OwnEuler):
    """Euler-Maruyama with half of the drift."""

    name: ClassVar[str] = "planted-half-drift"

    def run(self, problem: SDE, h: float, T: float, paths: int, seed: int) -> Ends:
        """Run the equation with half of its drift."""
        return super().run(halved(problem), h, T, paths, seed)


@lru_cache(maxsize=4)
def halved(problem: SDE) -> SDE:
    """Return the equation with half of its drift."""
    return replace(problem, drift=lambda t, x: 0.5 * problem.drift(t, x))


class Loud(OwnEuler):
    """Euler-Maruyama whose increments have 1.1 times the standard deviation."""

    name: ClassVar[str] = "planted-loud"

    def drawn(self, rng: np.random.Generator, h: float, shape: tuple[int, ...]) -> Array:
        """Return the increments of one step."""
        return 1.1 * super().drawn(rng, h, shape)


class TailsRedrawn(OwnEuler):
    """Euler-Maruyama that draws an increment again while it is larger than 1.5 standard deviations."""

    name: ClassVar[str] = "planted-clipped"

    def drawn(self, rng: np.random.Generator, h: float, shape: tuple[int, ...]) -> Array:
        """Return the increments of one step."""
        dW = super().drawn(rng, h, shape)
        while (large := np.abs(dW) > 1.5 * np.sqrt(h)).any():
            dW[large] = super().drawn(rng, h, (int(large.sum()),))
        return dW


class FirstOrder(OwnEuler):
    """Euler-Maruyama that claims weak order 2."""

    name: ClassVar[str] = "planted-first-order"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, margin=0.45, source="made up"),)


class Seedless(OwnEuler):
    """Euler-Maruyama that ignores its seed."""

    name: ClassVar[str] = "planted-seedless"

    def run(self, problem: Any, h: float, T: float, paths: int, seed: int) -> Ends:
        """Run with the seed 1."""
        return super().run(problem, h, T, paths, 1)


class Shared(OwnEuler):
    """Euler-Maruyama whose paths of a run are driven by one motion in four."""

    name: ClassVar[str] = "planted-shared"

    def drawn(self, rng: np.random.Generator, h: float, shape: tuple[int, ...]) -> Array:
        """Return the increments of one step: every four paths have the same."""
        rows, paths = shape
        return np.repeat(super().drawn(rng, h, (rows, -(-paths // 4))), 4, axis=1)[:, :paths]


@hookimpl
def sdaeverify_sealed() -> list[Sealed]:
    """Register the solvers."""
    return [FirstOrder(), HalfDrift(), Loud(), Seedless(), Shared(), TailsRedrawn(), Warm()]
