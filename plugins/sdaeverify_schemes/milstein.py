"""Milstein's scheme for scalar and for diagonal noise."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

from ._senses import by_growth


class Milstein(Scheme):
    """x+ = x + f h + B dW + (1/2) sum_j DB_j(x) B_j(x) (dW_j^2 - h).

    Complete to this order if the columns B_j commute trivially: one Brownian motion, or diagonal noise.
    """

    name: ClassVar[str] = "milstein"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, Theorem 10.3.5"),
            Claim(measure="weak", value=1.0, source="Kloeden & Platen 1992, section 14.1: Euler's weak order"),
        ),
        Claim(measure="drift", value=1.0, source="no projection; at least the strong order, g being Lipschitz"),
        Claim(measure="stability", value="conditional", source="measured; Higham 2000 treats Euler's scheme"),
    )
    source: ClassVar[str] = "Milstein 1974; Kloeden & Platen 1992, (10.3.1) and (10.3.12)"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that needs iterated integrals, and diffusions without a derivative."""
        if not problem.traits & {"scalar-noise", "diagonal-noise"}:
            return f"noise in {problem.noise_dim} dimensions is neither scalar nor diagonal"
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        B = problem.diffusion(t, x)
        double = 0.5 * (noise.dW**2 - h)
        if problem.noise_dim == 1:
            correction = problem.derivative_of_diffusion(t, x, B[:, 0])[:, 0] * double
        else:
            DB = problem.derivative_of_diffusion(t, x, np.einsum("jjp->jp", B))
            correction = np.einsum("jjp->jp", DB) * double
        return Step(x + h * problem.drift(t, x) + apply(B, noise.dW) + correction)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Milstein()]
