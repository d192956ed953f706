"""Milstein's scheme for noncommutative noise, with Levy areas or without them."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

from ._senses import by_growth


class MilsteinAreas(Scheme):
    """x+ = x + f h + B dW + sum_jk DB_k(x) B_j(x) I_jk with the double integrals of Ito.

    I_jk = int int dW_j dW_k = (dW_j dW_k - h delta_jk)/2 + A_jk consists of increments and Levy areas. For
    commutative noise DB_k B_j = DB_j B_k, and the areas cancel.
    """

    name: ClassVar[str] = "milstein-areas"
    form: ClassVar[type[SDE]] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, Theorem 10.3.5"),
            Claim(measure="weak", value=1.0, source="Kloeden & Platen 1992, section 14.1: Euler's weak order"),
        ),
    )
    source: ClassVar[str] = "Milstein 1974; Kloeden & Platen 1992, (10.3.3)"

    def refuses(self, problem: SDE) -> str:
        """Refuse one Brownian motion, which has no areas, and diffusions without a derivative."""
        if problem.noise_dim == 1:
            return "one Brownian motion has no areas: that is Milstein's scheme"
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, B, integrals = state, problem.diffusion(t, state), noise.double_integrals(h)
        moved = x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        for j in range(problem.noise_dim):
            column = np.broadcast_to(B[:, j], x.shape)
            moved = moved + np.einsum("dkp,kp->dp", problem.derivative_of_diffusion(t, x, column), integrals[j])
        return Step(moved)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [MilsteinAreas()]
