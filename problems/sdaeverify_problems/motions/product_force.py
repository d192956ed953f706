"""Two Ornstein-Uhlenbeck processes whose product is a force: additive noise and a nonlinear drift."""

from collections.abc import Callable

import numpy as np
import scipy

from sdaeverify import SDE, Array, hookimpl

from .. import _controls as controls
from .._known import moments, monomials

SOURCE = "Ito's formula: linear equations for five products"
NAMES = ("x_2", "x_3", "x_1 x_2", "x_1 x_3", "x_1^2 x_2")


def product_force(
    a: float = 1.5, b: float = 0.5, c: float = 2.0, s: float = 0.4, r: float = 0.3, horizon: float = 1.0
) -> SDE:
    """Product as a force: dx_j = -a x_j dt + s dW_j for j = 1 and 2, dx_3 = (c x_1 x_2 - b x_3) dt + r dW_1.

    x(0) = (2, 1, 0). By Ito's formula, the expectations of five products satisfy a closed linear system,

        (E x_2)' = -a E x_2,                          (E x_3)' = -b E x_3 + c E x_1 x_2,
        (E x_1 x_2)' = -2a E x_1 x_2,                 (E x_1^2 x_2)' = -3a E x_1^2 x_2 + s^2 E x_2,
        (E x_1 x_3)' = -(a + b) E x_1 x_3 + c E x_1^2 x_2 + s r.

    The drift has a mixed second derivative along the two motions, f(b_1, b_2) = (0, 0, c s^2): a scheme of weak order
    2 with correlated variables for the two motions is wrong on this problem, but right if the drift is linear.

    Parameters
    ----------
    a : float
        Rate of the first two components, unit 1/time.
    b : float
        Rate of the third component, unit 1/time.
    c : float
        Strength of the product, unit 1/time.
    s : float
        Noise amplitude of the first two components, unit 1/sqrt(time).
    r : float
        Noise amplitude of the third component, unit 1/sqrt(time).
    horizon : float
        Final time.

    Source
    ------
    Arnold (1974), section 8.5, for products in the place of components.
    """
    start, noise = np.array([2.0, 1.0, 0.0]), np.array([[s, 0.0], [0.0, s], [r, 0.0]])
    # Matrix of the linear system for (1, *NAMES).
    L = np.zeros((6, 6))
    L[1, 1], L[2, 2], L[3, 3], L[4, 4], L[5, 5] = -a, -b, -2.0 * a, -a - b, -3.0 * a
    L[2, 3], L[4, 5], L[4, 0], L[5, 1] = c, c, s * r, s * s
    x_1, x_2, x_3 = start
    products = np.array([1.0, x_2, x_3, x_1 * x_2, x_1 * x_3, x_1**2 * x_2])

    def value(row: int) -> Callable[[float], float]:
        return lambda t: float((scipy.linalg.expm(L * t) @ products)[row])

    def drift(t: float, x: Array) -> Array:
        return np.stack([-a * x[0], -a * x[1], c * x[0] * x[1] - b * x[2]])

    return SDE(
        controls=controls.ADDITIVE,
        drift=drift,
        diffusion=lambda t, x: noise[..., None],
        diffusion_derivative=lambda t, x, y: np.zeros((3, 2, 1)),
        start=start,
        noise_dim=2,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables=monomials(*NAMES),
        truths=moments({name: value(row) for row, name in enumerate(NAMES, 1)}, SOURCE),
        units="x dimensionless, time in the unit of 1/a",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [product_force]
