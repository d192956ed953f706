"""Euler-Maruyama with step sizes chosen before the noise is evaluated."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl
from sdaeverify.numerics import norm

from ..contract import TOLERANCES, Adaptive, why_not_own_times
from ..marching import LONGEST, Front, Marching, Stretch, Tried, powers
from ..path import TICKS, Path
from .embedded import at

SOURCE = "Fang & Giles 2020, arXiv:1609.08101: strong order 1/2 with previsible steps, here at most tol T"


class EulerPrevisible(Marching):
    """Euler-Maruyama with h = tol T s^2/(s^2 + |f|^2 + |B|^2), s = 1 + |x|, rounded to a power of 2 times T.

    The length is a function of the state at the beginning of the step: no step is rejected or depends on its noise.
    """

    name: ClassVar[str] = "euler-previsible"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, source=SOURCE),
        Claim(measure="tolerance-steps", value=0.5, source=SOURCE),
    )
    source: ClassVar[str] = (
        "Fang & Giles 2020, Adaptive Euler-Maruyama method for SDEs with nonglobally Lipschitz drift"
    )
    tolerances: ClassVar[tuple[float, ...]] = TOLERANCES[:4]
    evaluations_of_step: ClassVar[int] = 1

    def refuses(self, problem: SDE) -> str:
        """Refuse coefficients that accept no array of times."""
        return why_not_own_times(problem)

    def advance(self, problem: SDE, path: Path, front: Front, tolerance: float) -> Front:
        """Return the state of the integration one step later."""
        t = np.asarray(front.here.tick * path.tick)
        sized = front._replace(size=self.chosen(problem, t, front.x, tolerance))
        there = self.ahead(path, sized)
        x = self.attempt(problem, Stretch(path, front.x, front.here, there)).x
        return sized._replace(x=x, here=there, steps=front.steps + 1)

    def chosen(self, problem: SDE, t: Array, x: Array, tolerance: float) -> Array:
        """Return the length of a step in ticks, shape (P,).

        Parameters
        ----------
        problem : SDE
            Problem whose coefficients determine the length.
        t : ndarray, shape (P,)
            Times at the beginning of the steps.
        x : ndarray, shape (d, P)
            States at these times.
        tolerance : float
            Largest step as a part of T.
        """
        f, B, s = at(problem.drift, t, x), at(problem.diffusion, t, x), 1.0 + norm(x)
        change = norm(f) ** 2 + (B**2).sum(axis=(0, 1))
        return powers(np.minimum(tolerance * TICKS * s**2 / (s**2 + change), LONGEST))

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step, without an error estimate."""
        return Tried(euler(problem, step), 0.0 * step.x)


def euler(problem: SDE, step: Stretch) -> Array:
    """Return an Euler step."""
    return problem.euler(step.t, step.x, step.h, step.noise)  # type: ignore[arg-type] # times: see `why_not_own_times`


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register the solver."""
    return [EulerPrevisible()]
