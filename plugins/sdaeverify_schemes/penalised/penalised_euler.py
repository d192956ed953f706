"""Euler-Maruyama for penalised Langevin dynamics, with steps shorter than eps."""

from typing import ClassVar

from sdaeverify import Array, Claim, ConstrainedLangevin, Increment, Scheme, Step, hookimpl

from .._small_steps import STABLE
from ._langevin_noise import LangevinScheme


class PenalisedEuler(LangevinScheme):
    """x+ = x + sqrt(h) sigma xi + h f + (h sigma^2/4) grad ln det G - (h/eps) g G^{-1} zeta, (1.5).

    The scheme is stable only for h of the size of eps.
    """

    name: ClassVar[str] = "penalised-euler"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, source="Laurent 2022, section 1, for h much smaller than eps"),
        Claim(measure="invariant", value=1.0, source="Laurent 2022, section 1: the weak order at least"),
        STABLE,
        Claim(
            measure="strong",
            value=1.0,
            source="Kloeden & Platen 1992, section 10.3: Milstein's scheme, the noise being additive",
        ),
    )
    source: ClassVar[str] = "Laurent 2022, (1.5)"

    def refuses(self, problem: ConstrainedLangevin) -> str:
        """Refuse the limit, where there is no penalty."""
        return "" if problem.eps else "eps = 0: there is no penalty term"

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        at = problem.near(state)
        drift = problem.drift(state) + 0.25 * problem.strength**2 * at.fixman
        return Step(state + problem.strength * noise.dW + h * drift - (h / problem.eps) * at.relaxation)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [PenalisedEuler()]
