"""Platen's explicit scheme of weak order 2 for scalar, diagonal and additive noise."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

from ._senses import by_growth
from ._small_steps import STABLE

SEPARATE = frozenset({"scalar-noise", "diagonal-noise", "additive-noise"})


class PlatenWeak2(Scheme):
    """Supporting values y = x + h f + B dW and y_+- = x + h f +- sqrt(h) sum_j B_j.

    With f and B taken at (t, x), f' and B' at time t + h,

        x+ = x + (h/2) [f + f'(y)] + (1/4) [B'(y_+) + B'(y_-) + 2 B] dW
               + (1/4) [B'(y_+) - B'(y_-)] (dW^2 - h) / sqrt(h).

    Each column B_j has separate supporting values. For diagonal noise all of them can be evaluated at once, because
    B_j depends on the component j alone, on which it acts. Other noise needs two-point variables in addition to dW.
    """

    name: ClassVar[str] = "platen-weak-2"
    form: ClassVar[type[SDE]] = SDE
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(Claim(measure="weak", value=2.0, source="Kloeden & Platen 1992, section 15.1")),
        Claim(
            measure="invariant",
            value=2.0,
            when=frozenset({"unconstrained"}),
            source="Talay 1990: the weak order, for ergodic problems; bounded increments do not explode",
        ),
        STABLE,
    )
    source: ClassVar[str] = "Kloeden & Platen 1992, (15.1.1) and (15.1.3)"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is neither scalar nor diagonal nor additive."""
        if problem.traits & SEPARATE:
            return ""
        return f"noise in {problem.noise_dim} dimensions is neither scalar nor diagonal nor additive"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, dW = state, noise.dW
        f, B = problem.drift(t, x), problem.diffusion(t, x)
        centre, spread = x + h * f, np.sqrt(h) * B.sum(axis=1)
        up, down = (problem.diffusion(t + h, centre + sign * spread) for sign in (1.0, -1.0))
        drift = 0.5 * h * (f + problem.drift(t + h, centre + apply(B, dW)))
        kick = 0.25 * (apply(up + down + 2.0 * B, dW) + apply(up - down, dW * dW - h) / np.sqrt(h))
        return Step(x + drift + kick)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [PlatenWeak2()]
