"""The splitting scheme BAOAB for Langevin dynamics, of order 2 in law."""

from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, Increment, Langevin, Scheme, Step, hookimpl

from ._small_steps import STABLE


class BAOAB(Scheme):
    """Half a kick, half a move, the exact Ornstein-Uhlenbeck step of the momentum, half a move, half a kick.

    With c = e^{-gamma h},

        p <- p + (h/2) F(q),   q <- q + (h/2) p,   p <- c p + sigma sqrt((1 - c^2)/(2 gamma)) dW/sqrt(h),
        q <- q + (h/2) p,      p <- p + (h/2) F(q).

    The middle step has the law of the exact one, not its path: int e^{-gamma (h-s)} dW differs from the multiple of
    dW by a term of size h^(3/2) and mean 0, and so does int W ds from (h/2) dW. Therefore the strong order is 1.
    """

    name: ClassVar[str] = "baoab"
    form: ClassVar[type[Langevin]] = Langevin
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="measured; local errors of size h^(3/2), and h^2 in the mean"),
        Claim(measure="weak", value=2.0, source="Leimkuhler & Matthews 2013"),
        Claim(measure="invariant", value=2.0, source="Leimkuhler, Matthews & Stoltz 2016"),
        STABLE,
    )
    source: ClassVar[str] = "Leimkuhler & Matthews 2013"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state (q, p) has shape (2 n, P)."""
        n, gamma = problem.noise_dim, problem.friction
        q, p = state[:n], state[n:]
        # (1 - c^2)/(2 gamma), which is h without friction.
        variance = -np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma > 0.0 else h
        p = p + 0.5 * h * problem.force(q)
        middle = np.exp(-gamma * h) * p + problem.strength * np.sqrt(variance / h) * noise.dW
        q = q + 0.5 * h * (p + middle)
        return Step(np.concatenate([q, middle + 0.5 * h * problem.force(q)]))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [BAOAB()]
