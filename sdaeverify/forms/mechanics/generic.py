"""Random constrained mechanics: polynomial force, noise and constraints, a full mass matrix."""

from typing import Any

import numpy as np

from ...arrays import Array
from ..generic import (
    Generator,
    Polynomial,
    draw_near,
    draw_polynomial,
    draw_regular,
    draw_signed,
    with_linear_part,
)

POSITIONS, CONSTRAINTS, MOTIONS = 4, 2, 3
MASS, SEVERAL, CURVED, SPEED, STATE, MOVING, MANY, TIMED = (
    "mass",
    "constraints",
    "curvature",
    "velocity-noise",
    "state-noise",
    "velocity-force",
    "motions",
    "time",
)
FEATURES = {
    TIMED: "coefficients that depend on time",
    MOVING: "a force that depends on the velocity",
    STATE: "noise that depends on position or time",
    SPEED: "noise that depends on the velocity",
    MANY: "several Brownian motions",
    CURVED: "curved constraints",
    SEVERAL: "several constraints",
    MASS: "a mass matrix that is not the identity",
}
HORIZON, TIMES = 0.5, (0.1, 0.3)
# The constraint's bound holds within this distance from the start, with a safety factor; steps stay near the start.
RADIUS, SAMPLES, RESERVE = 0.5, 256, 1.5


def draw_mechanics(form: Any, rng: Generator, without: frozenset[str]) -> Any:
    """Draw a problem of constrained mechanics without the given features.

    Parameters
    ----------
    form : type
        `HolonomicSDAE`.
    rng : numpy.random.Generator
    without : frozenset of str
        Names of features.
    """
    n, m, l = POSITIONS, 1 if SEVERAL in without else CONSTRAINTS, 1 if MANY in without else MOTIONS
    r, v, t = 1.0 + draw_signed(rng, (n,)), 2.0 * draw_signed(rng, (n,)), float(rng.uniform(*TIMES))
    root = draw_regular(rng, n, n)
    M = np.eye(n) if MASS in without else root @ root.T
    g = with_linear_part(draw_polynomial(rng, r, m), draw_regular(rng, m, n))
    g = g.up_to(1) if CURVED in without else g
    inverse, derivatives = np.linalg.inv(M), _Constraint(g)
    A = derivatives.jacobian(r[:, None])[..., 0]
    v = v - inverse @ A.T @ np.linalg.solve(A @ inverse @ A.T, A @ v)
    a, B = (draw_polynomial(rng, np.concatenate([[t], r, v]), rows) for rows in (n, n * l))
    a, B = _narrowed(a, B, n, without)
    force = _MechanicalCoefficient(a, (n,))
    return form(
        force=force,
        force_derivatives=force.derivatives,
        diffusion=_MechanicalCoefficient(B, (n, l)),
        constraint=g,
        jacobian=derivatives.jacobian,
        curvature=derivatives.curvature,
        constraint_bound=_bound(rng, g, inverse, r),
        position=r,
        velocity=v,
        mass=None if MASS in without else M,
        noise_dim=l,
        horizon=HORIZON,
        traits=frozenset({"vanishing-milstein-term"} if {SPEED, STATE} & without else ()),
        source="drawn at random",
        observables={"r_1": lambda _, s: s["r"][0], "|v|^2": lambda _, s: (s["v"] ** 2).sum(axis=0)},
    )


def _narrowed(a: Polynomial, B: Polynomial, n: int, without: frozenset[str]) -> tuple[Polynomial, Polynomial]:
    """Return force and noise, polynomials of (t, r, v), without the given features."""
    velocities = range(1 + n, 1 + 2 * n)
    if TIMED in without:
        a, B = a.without(0), B.without(0)
    if MOVING in without:
        a = a.without(*velocities)
    if SPEED in without:
        B = B.without(*velocities)
    return a, B.up_to(0) if STATE in without else B


class _MechanicalCoefficient:
    # A polynomial as a function of (t, r, v) with values of a given shape.
    def __init__(self, f: Polynomial, shape: tuple[int, ...]) -> None:
        self.f, self.shape, self.first = f, shape, f.derivative

    def __call__(self, t: float, r: Array, v: Array) -> Array:
        return self.f(_stacked(t, r, v)).reshape(*self.shape, -1)

    def derivatives(self, t: float, r: Array, v: Array) -> tuple[Array, Array]:
        """Return the derivatives by r and by v."""
        n = len(r)
        found = self.first(_stacked(t, r, v)).reshape(*self.shape, 1 + 2 * n, -1)
        return found[:, 1 : 1 + n], found[:, 1 + n :]


class _Constraint:
    # The derivatives of a polynomial constraint g(r).
    def __init__(self, g: Polynomial) -> None:
        self.shape, self.first = (len(g.coefficients), len(g.centre)), g.derivative
        self.second = self.first.derivative

    def jacobian(self, r: Array) -> Array:
        return self.first(r).reshape(*self.shape, -1)

    def curvature(self, r: Array, y: Array, z: Array) -> Array:
        H = self.second(r).reshape(*self.shape, len(r), -1)
        return np.asarray(np.einsum("mijp,ip,jp->mp", H, y, z))


def _stacked(t: float, r: Array, v: Array) -> Array:
    return np.concatenate([t + 0.0 * r[:1], r, v])


def _bound(rng: Generator, g: Polynomial, inverse: Array, r: Array) -> float:
    """Return C_g of Lindner & Stroot (2017), (2.7): the maximum over positions near r, times a safety factor."""
    m, n = len(g.coefficients), len(r)
    near = draw_near(rng, r, SAMPLES, RADIUS)
    Dg = np.moveaxis(g.derivative(near).reshape(m, n, -1), -1, 0)
    G = Dg @ inverse @ Dg.swapaxes(1, 2)
    second = np.moveaxis(g.derivative.derivative(near).reshape(m * n, n, -1), -1, 0)
    third = g.derivative.derivative.derivative(near[:, :1]).reshape(m * n * n, n)
    sizes = [inverse @ Dg.swapaxes(1, 2), G, np.linalg.inv(G), second]
    largest = max(float(np.linalg.norm(each, 2, axis=(1, 2)).max()) for each in sizes)
    return RESERVE * max(largest, float(np.linalg.norm(third, 2)), 1.0)
