"""Motion on an ellipse with the drift of another measure; it claims what projected Euler keeps."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, Step, hookimpl
from sdaeverify.numerics import apply, apply_transposed, product_transposed, second_directional, solve
from sdaeverify_lab import Planted
from sdaeverify_schemes.projections.projected_euler import ProjectedEuler

from ._projection import project_step

DELTA = "ellipse[measure=delta]"


class RadialProjection(ProjectedEuler):
    """y = x + h P f + B dW with the tangential part P f of the drift, then onto g = 0 towards the origin.

    Along the normal, the projection supplies the normal part of f, which it replaces here by a wrong one.
    """

    name: ClassVar[str] = "planted-projected-radially"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        y = tangential(problem, state, t, h, noise)
        return project_step(problem, state, y, y[None])


@dataclass(frozen=True)
class WrongFixman(ProjectedEuler):
    """Drift f + part F with the Fixman drift F = -(1/2) t D^2 g(grad g, t)/|grad g|^2, t the unit tangent.

    Attributes
    ----------
    part : float
        0 is right; where f contains F, -1 takes it away and -2 turns its sign.
    """

    part: float = 1.0

    name: ClassVar[str] = "planted-fixman"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, tangent = state, problem.diffusion(t, state)[:, 0]
        f = problem.drift(t, x) + self.part * fixman(problem, x, tangent)
        y = x + h * f + tangent * noise.dW
        return project_step(problem, x, y, problem.dg(y))


def tangential(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    """Return x + h P f + B dW, P the orthogonal projector onto the tangent at x.

    Parameters
    ----------
    problem : SDE
        With a constraint.
    x : ndarray, shape (d, P)
    t, h : float
        Start and size of the step.
    noise : Increment
    """
    f, Dg = problem.drift(t, x), problem.dg(x)
    normal = apply_transposed(Dg, solve(product_transposed(Dg, Dg), apply(Dg, f)))
    return x + h * (f - normal) + apply(problem.diffusion(t, x), noise.dW)


def fixman(problem: SDE, x: Array, tangent: Array) -> Array:
    """Return F = -(1/2) t <t, grad log |grad g|>, the drift from arc length to the measure delta(g).

    Parameters
    ----------
    problem : SDE
        With one constraint.
    x : ndarray, shape (d, P)
    tangent : ndarray, shape (d, P)
        Unit vector t along the curve.
    """
    assert problem.constraint is not None
    gradient = problem.dg(x)[0]
    turned = second_directional(problem.constraint, x, gradient, tangent)
    return np.asarray(-0.5 * tangent * turned / (gradient * gradient).sum(axis=0))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="ellipse: radial projection, arc length", scheme=RadialProjection(), problem="ellipse"),
        Planted(bug="ellipse: radial projection, delta(g)", scheme=RadialProjection(), problem=DELTA),
        Planted(bug="ellipse: Fixman drift missing", scheme=WrongFixman(-1.0), problem=DELTA),
        Planted(bug="ellipse: Fixman drift with the wrong sign", scheme=WrongFixman(-2.0), problem=DELTA),
        Planted(bug="ellipse: spurious Fixman drift", scheme=WrongFixman(1.0), problem="ellipse"),
    ]
