"""BAOAB and other schemes for an invariant law with a wrong part; they claim its order."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Langevin, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive


@dataclass(frozen=True)
class WrongBAOAB(BAOAB):
    """BAOAB with c = e^{-gamma h} and s = sigma sqrt((1 + excess) (1 - c^2)/(2 gamma h)).

    Attributes
    ----------
    excess : float
        Of the variance of the noise.
    linear : bool
        Whether c = 1 - gamma h.
    early : bool
        Whether the friction acts on the noise as well, c (p + s dW).
    last : str
        The last kick: ``new`` at the new position is right, ``stale`` is at the old one, ``none`` is none.
    """

    excess: float = 0.0
    linear: bool = False
    early: bool = False
    last: str = "new"

    name: ClassVar[str] = "planted-baoab"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state (q, p) has shape (2 n, P)."""
        n, gamma = problem.noise_dim, problem.friction
        old, p = state[:n], state[n:] + 0.5 * h * problem.force(state[:n])
        decay = 1.0 - gamma * h if self.linear else np.exp(-gamma * h)
        variance = (1.0 + self.excess) * -np.expm1(-2.0 * gamma * h) / (2.0 * gamma)
        kick = problem.strength * np.sqrt(variance / h) * noise.dW
        middle = decay * (p + kick) if self.early else decay * p + kick
        q = old + 0.5 * h * (p + middle)
        force = {"new": problem.force(q), "stale": problem.force(old), "none": np.zeros_like(q)}[self.last]
        return Step(np.concatenate([q, middle + 0.5 * h * force]))


class EulerOfOrderTwo(EulerMaruyama):
    """Euler-Maruyama that claims weak and invariant order 2."""

    name: ClassVar[str] = "planted-em-claims-weak-2"
    claims: ClassVar[tuple[Claim, ...]] = HeunAdditive.claims


class HeunWithWrongVariance(HeunAdditive):
    """Heun's scheme for additive noise whose variance is 1 % too large."""

    name: ClassVar[str] = "planted-heun-variance"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(1.01) * noise.dW))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Scheme] = {
        "BAOAB: c = 1 - gamma h": WrongBAOAB(linear=True),
        "BAOAB: variance +5 %": WrongBAOAB(excess=0.05),
        "BAOAB: variance +1 %": WrongBAOAB(excess=0.01),
        "BAOAB: missing last kick": WrongBAOAB(last="none"),
        "BAOAB: stale force": WrongBAOAB(last="stale"),
        "BAOAB: friction on the noise": WrongBAOAB(early=True),
        "EM: weak and invariant order 2 claimed": EulerOfOrderTwo(),
        "Heun: noise variance +1 %": HeunWithWrongVariance(),
    }
    return [Planted(bug=bug, scheme=scheme, problem="angle-pendulum") for bug, scheme in bugs.items()]
