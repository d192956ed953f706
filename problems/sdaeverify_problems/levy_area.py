"""A point on the circle rotated by the Levy area of two Brownian motions, with noises that do not commute."""

import numpy as np

from sdaeverify import SDE, Array, Increment, Parts, hookimpl

from . import _controls as controls
from ._known import moments, solution

SOURCE = "Ito's formula for e^{i c A}; Levy 1951 for its expectation"


def levy_area(c: float = 2.0, horizon: float = 1.0) -> SDE:
    """Rotation by an area: (u, v) = (cos c A, sin c A) with A(t) = (1/2) int W_1 dW_2 - W_2 dW_1, and W itself.

    dw_1 = dW_1,   dw_2 = dW_2,   with r^2 = w_1^2 + w_2^2

    du = -(c^2/8) r^2 u dt + (c/2) v (w_2 dW_1 - w_1 dW_2),
    dv = -(c^2/8) r^2 v dt - (c/2) u (w_2 dW_1 - w_1 dW_2).

    The Lie bracket of the noises rotates the point: strong order 1 is impossible without areas. The coefficients grow
    like |x|^2. The area A of a path follows from those of its steps by Chen's relation, and
    E cos c A(t) = 1/cosh(c t/2).

    Parameters
    ----------
    c : float
        Angle per unit of area, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Levy (1951), Wiener's random function, and other Laplacian random functions.
    """

    def drift(t: float, x: Array) -> Array:
        rate = -(c**2) / 8.0 * (x[0] ** 2 + x[1] ** 2)
        return np.stack([0.0 * x[0], 0.0 * x[1], rate * x[2], rate * x[3]])

    def diffusion(t: float, x: Array) -> Array:
        u, v = 0.5 * c * x[2], 0.5 * c * x[3]
        zero = 0.0 * x[0]
        one = zero + 1.0
        return np.stack([one, zero, zero, one, v * x[1], -v * x[0], -u * x[1], u * x[0]]).reshape(4, 2, -1)

    def parts_of(t: float, z: Array) -> Parts:
        return {"x": np.stack([z[0], z[1], np.cos(c * z[2]), np.sin(c * z[2])])}

    def mean_u(t: float) -> float:
        return float(1.0 / np.cosh(0.5 * c * t))

    values = {
        "u": mean_u,
        "v": lambda t: 0.0,
        "u^2": lambda t: 0.5 + 0.5 / np.cosh(c * t),
        "w_1^2": lambda t: t,
    }
    return SDE(
        controls=controls.WITH_LEVY_AREAS,
        drift=drift,
        diffusion=diffusion,
        start=[0.0, 0.0, 1.0, 0.0],
        noise_dim=2,
        noise=frozenset({"dW", "H", "A"}),
        horizon=horizon,
        observables={
            "u": lambda t, s: s["x"][2],
            "v": lambda t, s: s["x"][3],
            "u^2": lambda t, s: s["x"][2] ** 2,
            "w_1^2": lambda t, s: s["x"][0] ** 2,
        },
        truths=(
            solution(np.zeros(3), advance, SOURCE, parts=parts_of),
            *moments(values, SOURCE),
        ),
        units="w in the unit of the square root of time, u and v dimensionless",
        source=SOURCE,
    )


def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
    """Return W_1, W_2 and A after one step, by Chen's relation.

    Parameters
    ----------
    z : ndarray, shape (3, P)
        Values of W_1, W_2 and A at time t.
    t, h : float
        Start and size of the step.
    noise : Increment
        Increment that contains the area A of the step.
    """
    (dW_1, dW_2), (area,) = noise.dW, noise.A
    return np.stack([z[0] + dW_1, z[1] + dW_2, z[2] + area + 0.5 * (z[0] * dW_2 - z[1] * dW_1)])


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [levy_area]
