"""The unit circle g(r) = (1 - |r|^2)/2 and motion on it in angle form, shared by the pendulums.

r = (sin theta, -cos theta), t = (cos theta, sin theta), v = omega t: theta is the angle from the lowest point.
"""

from collections.abc import Callable

import numpy as np

from sdaeverify import Angle, Array, Chart, Increment, Line, Parts, Pathwise

from .._known import monomials, solution

# C_g of Lindner & Stroot (2.7) on the eps-neighbourhood of the circle is 1/(1 - eps)^2 for any eps in (0, 1).
EPS = 0.01
CONSTRAINT_BOUND = 1.0 / (1.0 - EPS) ** 2


def constraint(r: Array) -> Array:
    """Return g(r) = (1 - |r|^2)/2, shape (1, P)."""
    return 0.5 * (1.0 - r[0] * r[0] - r[1] * r[1])[None]


def jacobian(r: Array) -> Array:
    """Return Dg(r) = -r^T, shape (1, 2, P)."""
    return -r[None]


def curvature(r: Array, y: Array, z: Array) -> Array:
    """Return D^2 g(r)(y, z) = -<y, z>, shape (1, P)."""
    return -(y[0] * z[0] + y[1] * z[1])[None]


def normal(theta: Array | float) -> Array:
    """Return the unit normal r(theta), shape (2, P)."""
    return np.stack([np.sin(theta), -np.cos(theta)])


def tangent(theta: Array | float) -> Array:
    """Return the unit tangent t(theta), shape (2, P)."""
    return np.stack([np.cos(theta), np.sin(theta)])


def direction(z: Array) -> Array:
    """Return (cos z, sin z), shape (1, P) -> (2, P)."""
    return np.concatenate([np.cos(z), np.sin(z)])


def quarter_turn(x: Array) -> Array:
    """Return J x, shape (2, P), for J = [[0, -1], [1, 0]]."""
    return np.stack([-x[1], x[0]])


def chart(centre: float, scale: float) -> Chart:
    """Return the chart with coordinates theta and omega, given centre and scale of the law of omega."""

    def embed(z: Array) -> Array:
        return np.concatenate([normal(z[0]), z[1] * tangent(z[0]), 0.0 * z[:1]])

    def read(x: Array) -> Array:
        return np.stack([np.arctan2(x[0], -x[1]), x[0] * x[3] - x[1] * x[2]])

    return Chart(axes=(Angle(), Line(centre, scale)), embed=embed, read=read)


def start(theta_0: float, omega_0: float) -> dict[str, Array]:
    """Return the initial position and velocity for an angle and an angular velocity."""
    return {"position": normal(theta_0), "velocity": omega_0 * tangent(theta_0)}


def parts(t: float, z: Array) -> Parts:
    """Return r, v and mu of a state with rows z = (theta, omega, mu)."""
    theta, omega, mu = z
    return {"r": normal(theta), "v": omega * tangent(theta), "mu": mu[None]}


def angle_truth(
    theta_0: float,
    omega_0: float,
    advance: Callable[[Array, float, float, Increment], Array],
    source: str,
) -> Pathwise:
    """Return the fine reference of strong order 3/2 with rows (theta, omega, mu)."""
    return solution([theta_0, omega_0, 0.0], advance, source, parts=parts, order=1.5)


def square_integral(h: float, noise: Increment) -> Array:
    """Return E[ int_0^h W(s)^2 ds | dW, H ] = h (dW^2/3 + dW H + 6 H^2/5) + h^2/15, shape (l, P).

    Given dW and H, W(s) has mean q dW + 6 q (1 - q) H, q = s/h, and its conditional variance has the integral h^2/15.
    """
    W, H = noise.dW, noise.H
    return h * (W * W / 3.0 + W * H + 1.2 * H * H) + h * h / 15.0


OBSERVABLES = {
    **monomials("r_1", "r_2", "v_1", "v_2"),
    "|v|^2": lambda t, s: (s["v"] ** 2).sum(axis=0),
    "|v|^4": lambda t, s: (s["v"] ** 2).sum(axis=0) ** 2,
    **monomials("mu", "mu^2"),
}
# Fields of mechanical problems on the circle with M = Id.
MECHANICS = {
    "constraint": constraint,
    "jacobian": jacobian,
    "curvature": curvature,
    "constraint_bound": CONSTRAINT_BOUND,
}
