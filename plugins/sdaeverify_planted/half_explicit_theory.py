"""The half-explicit scheme with all claims of its theory and without what keeps them."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import Claim, HolonomicSDAE, HolonomicState, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.projections.half_explicit_euler import BOUNDED, EVERY_H, HalfExplicitEuler


@dataclass(frozen=True)
class Untruncated(HalfExplicitEuler):
    """Without truncation it heats up and runs into states from which no step has a root."""

    truncation: str | float = "none"

    name: ClassVar[str] = "planted-half-explicit-untruncated"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """A root for every h, and bounded moments."""
        return EVERY_H, BOUNDED


@dataclass(frozen=True)
class MultiplierOutput(HalfExplicitEuler):
    """It gives out the multiplier of h a + B dw alone, without the Coriolis term, and sums up the right one."""

    truncation: str | float = "none"

    name: ClassVar[str] = "planted-half-explicit-multiplier-output"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result, J = super().step(problem, state, t, h, noise), problem.linearised(state.r)
        coriolis = -J.gram(J).solve(problem.d2g(state.r, state.v, state.v))
        return result._replace(outputs={**result.outputs, "lambda": result.outputs["lambda"] - h * coriolis})


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    fast = "pendulum[omega_0=5,horizon=1]"
    return [
        Planted(bug="pendulum: truncation dropped", scheme=Untruncated(), problem=fast),
        Planted(
            bug="pendulum: multiplier output without Coriolis term",
            scheme=MultiplierOutput(),
            problem="damped-pendulum",
        ),
    ]
