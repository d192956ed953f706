"""The balanced Euler scheme, whose implicitness depends on the noise: of order 1/2, also in the weak sense."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

from ._small_steps import STABLE


class BalancedEuler(Scheme):
    """x+ = x + h f(t, x) + B(t, x) dW + C (x - x+) with C = |dW_1| + ... + |dW_l|, solved for x+.

    x+ = x + (h f + B dW)/(1 + C): the mean of the step lacks h f C, of size h^(3/2), and its variance as much.
    """

    name: ClassVar[str] = "balanced-euler"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="Milstein, Platen & Schurz 1998"),
        Claim(measure="weak", value=0.5, source="local weak order 3/2, from E |dW| of size h^(1/2)"),
        # On the circle the estimate is 0.26 from 16 to 128 steps and 0.31 from 32 to 256: a large preasymptotic
        # range.
        Claim(measure="drift", value=0.5, margin=0.3, source="no projection; at least the strong order"),
        STABLE,
    )
    source: ClassVar[str] = "Milstein, Platen & Schurz 1998, with c_0 = 0 and c_j = Id"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        change = h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        return Step(x + change / (1.0 + np.abs(noise.dW).sum(axis=0)))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [BalancedEuler()]
