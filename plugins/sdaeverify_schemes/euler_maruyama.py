"""Explicit Euler schemes for SDEs: Euler-Maruyama and its drift-truncated variant."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply, norm

ORDERS = (
    Claim(measure="strong", value=0.5, source="Kloeden & Platen 1992, Theorem 10.2.2"),
    Claim(
        measure="strong",
        value=1.0,
        when=frozenset({"vanishing-milstein-term"}),
        source="Kloeden & Platen 1992, section 10.3: equal to Milstein's scheme",
    ),
    Claim(measure="drift", value=1.0, source="Lindner & Stroot 2017, Remark 3.3: no projection; order measured"),
)


@dataclass(frozen=True)
class EulerMaruyama(Scheme):
    """x+ = x + f(t, x) h + B(t, x) dW."""

    name: ClassVar[str] = "euler-maruyama"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = ORDERS
    source: ClassVar[str] = "Maruyama 1955; Kloeden & Platen 1992, (10.2.4)"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        return Step(x + h * problem.drift(t, x) + apply(problem.diffusion(t, x), noise.dW))


@dataclass(frozen=True)
class DriftTruncatedEuler(Scheme):
    """x+ = x + eta h f(t, x) + B(t, x) dW with eta = min(1, 1 / (h |f(t, x)|)).

    On a constrained problem it solves the inherent SDE and never projects, so that the constraints drift.
    """

    name: ClassVar[str] = "drift-truncated-euler"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = ORDERS
    source: ClassVar[str] = "Lindner & Stroot 2017, Remark 3.3"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        f = np.broadcast_to(problem.drift(t, x), x.shape)
        length = h * norm(f)
        eta = 1.0 / np.maximum(1.0, length)
        return Step(x + eta * h * f + apply(problem.diffusion(t, x), noise.dW), truncated=length > 1.0)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register both schemes."""
    return [EulerMaruyama(), DriftTruncatedEuler()]
