"""The half-explicit scheme with another multiplier."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import HolonomicSDAE, HolonomicState, Increment, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.projections._old_normals import onto_constraint
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

from ._half_explicit import kick, multiplier


@dataclass(frozen=True)
class MultiplierSign(HalfExplicitEuler):
    """mu+ = mu - lambda."""

    truncation: str | float = "none"

    name: ClassVar[str] = "planted-half-explicit-multiplier-sign"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=result.state._replace(mu=2.0 * state.mu - result.state.mu))


@dataclass(frozen=True)
class WithoutCoriolis(HalfExplicitEuler):
    """The multiplier of h a + B dw, without the Coriolis term D^2 g(v, v), acts on v before v is projected anyway."""

    truncation: str | float = "none"

    name: ClassVar[str] = "planted-half-explicit-without-coriolis"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        new = onto_constraint(problem, r + h * v, old)
        change = kick(problem, state, t, h, noise.dW)
        first = multiplier(problem, r, old, change)
        x = v + change + problem.push(old, first)
        lam = multiplier(problem, new.r, old, x)
        return Step(HolonomicState(new.r, x + problem.push(old, lam), mu + first + lam), ~new.found)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bug and the equivalent change."""
    return [
        Planted(bug="pendulum: multiplier sign", scheme=MultiplierSign(), problem="damped-pendulum"),
        Planted(
            bug="pendulum: multiplier without Coriolis term, velocity projected",
            scheme=WithoutCoriolis(),
            problem="damped-pendulum",
            equivalent="the projection of the velocity supplies the term that the multiplier lacks",
        ),
    ]
