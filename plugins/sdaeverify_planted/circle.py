"""Brownian motion on a circle that is projected wrongly or not at all; it claims what projected Euler keeps."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply_transposed, product_transposed, solve
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun
from sdaeverify_schemes.projections.projected_euler import ProjectedEuler

from ._projection import project_step


class FixedDirection(ProjectedEuler):
    """Projects along the first axis, wherever the normal is."""

    name: ClassVar[str] = "planted-projected-fixed-direction"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        axis = np.zeros((1, *state.shape))
        axis[0, 0] = 1.0
        return project_step(problem, state, problem.euler(t, state, h, noise), axis)


class OneNewtonStep(ProjectedEuler):
    """x+ = y - grad g(y) g(y)/|grad g(y)|^2: one step of the iteration that would end on the circle."""

    name: ClassVar[str] = "planted-projected-one-newton-step"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        assert problem.constraint is not None
        y = problem.euler(t, state, h, noise)
        Dg = problem.dg(y)
        return Step(y - apply_transposed(Dg, solve(product_transposed(Dg, Dg), problem.constraint(y))))


class GrownRadius(ProjectedEuler):
    """Onto the circle of radius 1 + h, from which the next step starts."""

    name: ClassVar[str] = "planted-projected-radius"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=(1.0 + h) * result.state)


class EulerNotProjected(EulerMaruyama):
    """Euler-Maruyama that claims to be projected."""

    name: ClassVar[str] = "planted-em-not-projected"
    claims: ClassVar[tuple[Claim, ...]] = ProjectedEuler.claims


class HeunNotProjected(Heun):
    """Heun's scheme that claims to be projected: its orders are right, its constraint is not."""

    name: ClassVar[str] = "planted-heun-not-projected"
    claims: ClassVar[tuple[Claim, ...]] = ProjectedEuler.claims


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Scheme] = {
        "fixed projection direction": FixedDirection(),
        "no projection, Euler-Maruyama": EulerNotProjected(),
        "no projection, Heun": HeunNotProjected(),
        "radius 1 + h": GrownRadius(),
        "one Newton step of the projection": OneNewtonStep(),
    }
    return [Planted(bug=f"circle: {bug}", scheme=scheme, problem="circle") for bug, scheme in bugs.items()]
