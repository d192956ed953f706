"""The projection-based Euler schemes with one of their parts changed; they claim what the right ones keep."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import HolonomicSDAE, HolonomicState, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.projections._new_normals import onto_constraint
from sdaeverify_schemes.projections._position_projection import Projection
from sdaeverify_schemes.projections._skipping import SkippingState, inherent_euler, projections
from sdaeverify_schemes.projections.explicit_projection_euler import ExplicitProjectionEuler
from sdaeverify_schemes.projections.semi_implicit_projection_euler import SemiImplicitProjectionEuler


@dataclass(frozen=True)
class WrongExplicit(ExplicitProjectionEuler):
    """The explicit scheme with another Coriolis term, or with part of its impulses in mu.

    Attributes
    ----------
    coriolis : float
        Factor of D^2 g(v, v); 1 is right.
    counted : float
        Factor of l in mu+ = mu + l^ + l; 1 is right.
    """

    coriolis: float = 1.0
    counted: float = 1.0

    name: ClassVar[str] = "planted-explicit-projection"

    def step(self, problem: HolonomicSDAE, state: SkippingState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        free = inherent_euler(problem, state, t, h, noise.dW)
        J = problem.linearised(state.r)
        turning = (self.coriolis - 1.0) * h * problem.inherent_multiplier(J, state.r, state.v, np.zeros_like(state.v))
        free = free._replace(v=free.v + problem.push(J, turning), mu=free.mu + turning)
        projection = Projection(self.solver, self.tolerance)
        result = projections(problem, state, free, state.skipped[0] >= self.skip, projection)
        mu = free.mu + self.counted * (result.state.mu - free.mu)
        return result._replace(state=result.state._replace(mu=mu))


@dataclass(frozen=True)
class WrongSemiImplicit(SemiImplicitProjectionEuler):
    """The semi-implicit scheme with another projection, or with part of its impulses in mu.

    Attributes
    ----------
    position : str
        The position is ``projected``, which is right, by Newton's first update, ``once``, or not at all, ``free``.
    tangent : str
        The velocity goes onto the ``new`` tangent space, which is right, onto the ``old`` one, or nowhere, ``free``.
    first, second : float
        Factors of l^ and l in mu+ = mu + l^ + l; 1 is right.
    """

    position: str = "projected"
    tangent: str = "new"
    first: float = 1.0
    second: float = 1.0

    name: ClassVar[str] = "planted-semi-implicit-projection"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old, y, found = problem.linearised(r), r + h * v, np.ones(r.shape[-1], dtype=bool)
        if self.position == "once":
            J = problem.linearised(y)
            y = y - problem.push(J, J.gram(J).solve(problem.constraint(y)))
        elif self.position == "projected":
            y, _, _, found, _ = onto_constraint(problem, y)
        kick, before = problem.tangent(old, problem.inverse_mass(problem.diffused(t, r, v, noise.dW)))
        x = v + problem.inverse_mass(h * problem.force(t + h, y, v)) + kick
        moved, after = problem.tangent(old if self.tangent == "old" else problem.linearised(y), x)
        impulse = self.first * before + self.second * after
        new = HolonomicState(y, x if self.tangent == "free" else moved, mu + impulse)
        return Step(HolonomicState(*(np.where(found, a, b) for a, b in zip(new, state, strict=True))), ~found)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs and the equivalent changes."""
    bugs: dict[str, Scheme] = {
        "wrong Coriolis term, what takes it back left out of mu": WrongExplicit(skip=3, coriolis=-1.0, counted=0.0),
        "velocity onto the old tangent space": WrongSemiImplicit(tangent="old"),
        "velocity not projected": WrongSemiImplicit(tangent="free"),
        "position not projected": WrongSemiImplicit(position="free"),
        "position projected by one Newton step": WrongSemiImplicit(position="once"),
        "impulse of the noise's projection left out of mu": WrongSemiImplicit(first=0.0),
        "impulse of the velocity's projection left out of mu": WrongSemiImplicit(second=0.0),
    }
    sign = "the projection of the velocity, in every step, takes back what the term has added"
    later = "what the term adds to the velocity is normal and of size h; the next projection takes it back, up to h^2"
    mean = "the explicit multiplier already has all but a part of mean O(h^2) and size O(h^(3/2))"
    same = {
        "Coriolis term with the other sign, projected in every step": (WrongExplicit(coriolis=-1.0), sign),
        "Coriolis term with the other sign, projected now and then": (
            WrongExplicit(skip=3, coriolis=-1.0),
            later,
        ),
        "impulse of the last projection left out of mu": (WrongExplicit(counted=0.0), mean),
    }
    return [
        *(
            Planted(bug=f"projection: {bug}", scheme=scheme, problem="damped-pendulum")
            for bug, scheme in bugs.items()
        ),
        *(
            Planted(bug=f"projection: {bug}", scheme=scheme, problem="damped-pendulum", equivalent=why)
            for bug, (scheme, why) in same.items()
        ),
    ]
