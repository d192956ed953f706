"""The half-explicit scheme without one of its parts; it claims what the whole scheme keeps."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, DenseJacobian, HolonomicSDAE, HolonomicState, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.projections._old_normals import onto_constraint
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

from ._half_explicit import kick, multiplier


@dataclass(frozen=True)
class WrongHalfExplicit(HalfExplicitEuler):
    """The scheme without truncation, one of its parts changed.

    Attributes
    ----------
    position : str
        The position goes along the old ``normal``, which is right, along a fixed ``axis`` or nowhere, ``free``. Where
        there is no point along the axis, it stays, and nobody is told.
    velocity : str
        The velocity goes onto the ``new`` tangent space, which is right, onto the ``old`` one, or nowhere, ``free``.
    strength : float
        Factor of dw.
    """

    truncation: str | float = "none"
    position: str = "normal"
    velocity: str = "new"
    strength: float = 1.0

    name: ClassVar[str] = "planted-half-explicit"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        y, failed = r + h * v, np.zeros(r.shape[-1], dtype=bool)
        if self.position != "free":
            new = onto_constraint(problem, y, old if self.position == "normal" else upright(problem.dg(r)))
            y, failed = np.where(new.found, new.r, r), ~new.found if self.position == "normal" else failed
        x = v + kick(problem, state, t, h, self.strength * noise.dW)
        if self.velocity == "free":
            return Step(HolonomicState(y, np.where(failed, v, x), mu), failed)
        lam = multiplier(problem, y if self.velocity == "new" else r, old, x)
        moved = x + problem.push(old, lam)
        return Step(HolonomicState(y, np.where(failed, v, moved), np.where(failed, mu, mu + lam)), failed)


@dataclass(frozen=True)
class AlongAxis(WrongHalfExplicit):
    """The position goes along the last axis: from near where that is tangential, it never gets past.

    Single steps do not show it. No claim about the invariant law: a chain moves between the sides too rarely to tell.
    """

    position: str = "axis"

    name: ClassVar[str] = "planted-half-explicit-axis"
    claims: ClassVar[tuple[Claim, ...]] = tuple(c for c in HalfExplicitEuler.claims if c.measure != "invariant")


class NoProjection(EulerMaruyama):
    """Euler-Maruyama for the inherent SDE that claims to be projected."""

    name: ClassVar[str] = "planted-em-inherent"
    claims: ClassVar[tuple[Claim, ...]] = HalfExplicitEuler.claims


def upright(normals: Array) -> DenseJacobian:
    """Return the last axis, on the side of the normals of shape (m, n, P), in place of them."""
    axes = np.zeros_like(normals)
    axes[:, -1] = np.copysign(1.0, normals[:, -1])
    return DenseJacobian(axes)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Scheme] = {
        "velocity constraint dropped": WrongHalfExplicit(velocity="free"),
        "velocity onto the old tangent space": WrongHalfExplicit(velocity="old"),
        "position projection dropped": WrongHalfExplicit(position="free"),
        "no projection": NoProjection(),
        "variance +1 %": WrongHalfExplicit(strength=1.01**0.5),
    }
    # From there every path falls past the horizontal, where the last axis is tangential.
    above = "damped-pendulum[theta_0=2.2,horizon=2]"
    return [
        *(Planted(bug=f"pendulum: {b}", scheme=s, problem="damped-pendulum") for b, s in bugs.items()),
        Planted(bug="pendulum: position projected along a fixed axis", scheme=AlongAxis(), problem=above),
    ]
