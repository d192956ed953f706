"""Explicit Euler schemes for SDEs: Euler-Maruyama and its drift-truncated and tamed variants."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import norm

from ._euler_orders import EXPLICIT_ORDERS, ORDERS
from ._senses import LINEAR_GROWTH


class EulerMaruyama(Scheme):
    """x+ = x + f(t, x) h + B(t, x) dW."""

    name: ClassVar[str] = "euler-maruyama"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        *EXPLICIT_ORDERS,
        Claim(
            measure="invariant",
            value=1.0,
            when=LINEAR_GROWTH | {"unconstrained"},
            source="Talay & Tubaro 1990, for ergodic problems",
        ),
        Claim(measure="stability", value="conditional", source="Higham 2000, with theta = 0"),
    )
    source: ClassVar[str] = "Maruyama 1955; Kloeden & Platen 1992, (10.2.4)"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        return Step(x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW))


class DriftTruncatedEuler(Scheme):
    """x+ = x + eta h f(t, x) + B(t, x) dW with eta = min(1, 1 / (h |f(t, x)|)).

    On a constrained problem it solves the inherent SDE without projection, so that the constraints drift.
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
        return Step(x + eta * h * f + problem.diffused(t, x, noise.dW), truncated=length > 1.0)


class TamedEuler(Scheme):
    """x+ = x + h f(t, x) / (1 + h |f(t, x)|) + B(t, x) dW.

    Taming changes every step by O(h^2) at a given state, so that no step is marked as truncated.
    """

    name: ClassVar[str] = "tamed-euler"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = ORDERS
    source: ClassVar[str] = "Hutzenthaler, Jentzen & Kloeden 2012"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        f = np.broadcast_to(problem.drift(t, x), x.shape)
        return Step(x + h * f / (1.0 + h * norm(f)) + problem.diffused(t, x, noise.dW))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the schemes."""
    return [EulerMaruyama(), DriftTruncatedEuler(), TamedEuler()]
