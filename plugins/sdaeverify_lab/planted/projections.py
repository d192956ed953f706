"""Schemes that project onto a constraint with one wrong part."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, DenseJacobian, HolonomicSDAE, HolonomicState, Increment, Step, hookimpl
from sdaeverify.numerics import apply, apply_transposed, product_transposed, second_directional, solve
from sdaeverify_lab import Planted
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun
from sdaeverify_schemes.projections._new_normals import onto_constraint as along_new_normals
from sdaeverify_schemes.projections._old_normals import onto_constraint
from sdaeverify_schemes.projections._position_projection import Projection
from sdaeverify_schemes.projections._skipping import SkippingState, inherent_euler, projections
from sdaeverify_schemes.projections.explicit_projection_euler import ExplicitProjectionEuler
from sdaeverify_schemes.projections.projected_euler import ProjectedEuler
from sdaeverify_schemes.projections.semi_implicit_projection_euler import SemiImplicitProjectionEuler

# Projection along given directions, for schemes with wrong ones.


def _project_step(problem: SDE, x: Array, y: Array, normals: Array) -> Step:
    """Return the step from x to the point of the constraint near y along directions of shape (1, d, P)."""
    new = onto_constraint(problem, y, DenseJacobian(normals))
    return Step(np.where(new.found, new.r, x), ~new.found)


# Brownian motion on a circle with a wrong projection or none, and the claims of projected Euler.


class FixedDirection(ProjectedEuler):
    """Projects along the first axis instead of the normal."""

    name: ClassVar[str] = "planted-projected-fixed-direction"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        axis = np.zeros((1, *state.shape))
        axis[0, 0] = 1.0
        return _project_step(problem, state, problem.euler(t, state, h, noise), axis)


class OneNewtonStep(ProjectedEuler):
    """x+ = y - grad g(y) g(y)/|grad g(y)|^2: a single iteration of the projection."""

    name: ClassVar[str] = "planted-projected-one-newton-step"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        assert problem.constraint is not None
        y = problem.euler(t, state, h, noise)
        Dg = problem.dg(y)
        return Step(y - apply_transposed(Dg, solve(product_transposed(Dg, Dg), problem.constraint(y))))


class GrownRadius(ProjectedEuler):
    """Projects onto the circle of radius 1 + h, from which the next step starts."""

    name: ClassVar[str] = "planted-projected-radius"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=(1.0 + h) * result.state)


class EulerNotProjected(EulerMaruyama):
    """Euler-Maruyama with the claims of a projected scheme."""

    name: ClassVar[str] = "planted-em-not-projected"
    claims: ClassVar[tuple[Claim, ...]] = ProjectedEuler.claims


class HeunNotProjected(Heun):
    """Heun's scheme with the claims of a projected scheme: right orders, violated constraint."""

    name: ClassVar[str] = "planted-heun-not-projected"
    claims: ClassVar[tuple[Claim, ...]] = ProjectedEuler.claims


# Motion on an ellipse with the drift of another measure, and the claims of projected Euler.


class RadialProjection(ProjectedEuler):
    """y = x + h P f + B dW with the tangential part P f of the drift, then projected radially onto g = 0.

    A projection along the normal would supply the normal part of f; the radial one replaces it by a wrong one.
    """

    name: ClassVar[str] = "planted-projected-radially"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        y = tangential(problem, state, t, h, noise)
        return _project_step(problem, state, y, y[None])


@dataclass(frozen=True)
class WrongFixman(ProjectedEuler):
    """Drift f + part F with the Fixman drift F = -(1/2) t D^2 g(grad g, t)/|grad g|^2, t the unit tangent.

    Attributes
    ----------
    part : float
        Factor of F; 0 is right. If f contains F, -1 removes it and -2 reverses its sign.
    """

    part: float = 1.0

    name: ClassVar[str] = "planted-fixman"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, tangent = state, problem.diffusion(t, state)[:, 0]
        f = problem.drift(t, x) + self.part * fixman(problem, x, tangent)
        y = x + h * f + tangent * noise.dW
        return _project_step(problem, x, y, problem.dg(y))


def tangential(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    """Return x + h P f + B dW with the orthogonal projector P onto the tangent space at x.

    Parameters
    ----------
    problem : SDE
        Problem with a constraint.
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
        Problem with one constraint.
    x : ndarray, shape (d, P)
    tangent : ndarray, shape (d, P)
        Unit vector t along the curve.
    """
    assert problem.constraint is not None
    gradient = problem.dg(x)[0]
    turned = second_directional(problem.constraint, x, gradient, tangent)
    return np.asarray(-0.5 * tangent * turned / (gradient * gradient).sum(axis=0))


# The projection-based Euler schemes with one wrong part, and the claims of the right schemes.


@dataclass(frozen=True)
class WrongExplicit(ExplicitProjectionEuler):
    """The explicit scheme with a wrong Coriolis term, or with part of its impulses in mu.

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
    """The semi-implicit scheme with a wrong projection, or with part of its impulses in mu.

    Attributes
    ----------
    position : str
        Projection of the position: ``projected`` (right), a single Newton update, ``once``, or none, ``free``.
    tangent : str
        Tangent space of the velocity's projection: ``new`` (right), ``old``, or none, ``free``.
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
            y, _, _, found, _ = along_new_normals(problem, y)
        kick, before = problem.tangent(old, problem.inverse_mass(problem.diffused(t, r, v, noise.dW)))
        x = v + problem.inverse_mass(h * problem.force(t + h, y, v)) + kick
        moved, after = problem.tangent(old if self.tangent == "old" else problem.linearised(y), x)
        impulse = self.first * before + self.second * after
        new = HolonomicState(y, x if self.tangent == "free" else moved, mu + impulse)
        return Step(HolonomicState(*(np.where(found, a, b) for a, b in zip(new, state, strict=True))), ~found)


BUGS = [
    Planted("circle: fixed projection direction", FixedDirection(), "circle"),
    Planted("circle: no projection, Euler-Maruyama", EulerNotProjected(), "circle"),
    Planted("circle: no projection, Heun", HeunNotProjected(), "circle"),
    Planted("circle: radius 1 + h", GrownRadius(), "circle"),
    Planted("circle: one Newton step of the projection", OneNewtonStep(), "circle"),
    Planted("ellipse: radial projection, arc length", RadialProjection(), "ellipse"),
    Planted("ellipse: radial projection, delta(g)", RadialProjection(), "ellipse[measure=delta]"),
    Planted("ellipse: Fixman drift missing", WrongFixman(-1.0), "ellipse[measure=delta]"),
    Planted("ellipse: Fixman drift with the wrong sign", WrongFixman(-2.0), "ellipse[measure=delta]"),
    Planted("ellipse: spurious Fixman drift", WrongFixman(), "ellipse"),
    Planted(
        "projection: wrong Coriolis term, what takes it back left out of mu",
        WrongExplicit(3, coriolis=-1.0, counted=0.0),
        "damped-pendulum",
    ),
    Planted("projection: velocity onto the old tangent space", WrongSemiImplicit(tangent="old"), "damped-pendulum"),
    Planted("projection: velocity not projected", WrongSemiImplicit(tangent="free"), "damped-pendulum"),
    Planted("projection: position not projected", WrongSemiImplicit(position="free"), "damped-pendulum"),
    Planted(
        "projection: position projected by one Newton step", WrongSemiImplicit(position="once"), "damped-pendulum"
    ),
    Planted(
        "projection: impulse of the noise's projection left out of mu",
        WrongSemiImplicit(first=0.0),
        "damped-pendulum",
    ),
    Planted(
        "projection: impulse of the velocity's projection left out of mu",
        WrongSemiImplicit(second=0.0),
        "damped-pendulum",
    ),
    Planted(
        "projection: Coriolis term with the other sign, projected in every step",
        WrongExplicit(coriolis=-1.0),
        "damped-pendulum",
        equivalent="the projection of the velocity, in every step, takes back what the term has added",
    ),
    Planted(
        "projection: Coriolis term with the other sign, projected now and then",
        WrongExplicit(3, coriolis=-1.0),
        "damped-pendulum",
        equivalent="what the term adds to the velocity is normal and of size h; the next projection takes it back, "
        "up to h^2",
    ),
    Planted(
        "projection: impulse of the last projection left out of mu",
        WrongExplicit(counted=0.0),
        "damped-pendulum",
        equivalent="the explicit multiplier already has all but a part of mean O(h^2) and size O(h^(3/2))",
    ),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
