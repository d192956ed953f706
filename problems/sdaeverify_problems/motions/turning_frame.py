"""Two noises that do not commute in a rotating frame, so that all coefficients depend on time."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Array, hookimpl

from .. import _controls as controls
from .._known import moments, monomials
from ._linear_moments import SOURCE, generator, mean, second

A = np.array([[-1.0, 0.5], [0.0, -0.4]])
B_1 = np.array([[0.4, 0.0], [0.0, -0.2]])
B_2 = np.array([[0.0, 0.3], [0.3, 0.0]])
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def turning_frame(omega: float = 1.0, x_1: float = 1.0, x_2: float = 0.5, horizon: float = 1.0) -> SDE:
    """Linear system in a turning frame: x = R(t) z, dz = A z dt + B_1 z dW_1 + B_2 z dW_2, R the rotation by omega t.

        dx = (omega J + R A R^T) x dt + R B_1 R^T x dW_1 + R B_2 R^T x dW_2,   J the rotation by pi/2,

    with A = [[-1, 1/2], [0, -0.4]], B_1 = diag(0.4, -0.2) and B_2 = [[0, 0.3], [0.3, 0]], of which no two commute.
    Hence E x = R exp(A t) x(0) and E x x^T = R (E z z^T) R^T. A scheme that evaluates drift or diffusion at a wrong
    time, such as t instead of t + h, is right on every autonomous problem, but not on this one.

    Parameters
    ----------
    omega : float
        Angular velocity of the frame, radian/time.
    x_1 : float
        Initial value of the first component.
    x_2 : float
        Initial value of the second component.
    horizon : float
        Final time, in the unit of the damping time.

    Source
    ------
    Arnold (1974), section 8.5: moments of linear equations, in coordinates that depend on time.
    """
    start, G = np.array([x_1, x_2]), generator(A, (B_1, B_2))

    def turned(t: float, *matrices: Array) -> Array:
        """Return R M R^T for each matrix M, shape (k, 2, 2)."""
        R = rotation(omega * t)
        return R @ np.stack(matrices) @ R.T

    def diffusion(t: float, x: Array) -> Array:
        return np.stack([B @ x for B in turned(t, B_1, B_2)], axis=1)

    def first(row: int) -> Callable[[float], float]:
        return lambda t: float((rotation(omega * t) @ mean(A, start, t))[row])

    def product(row: int, column: int) -> Callable[[float], float]:
        return lambda t: float(turned(t, second(G, start, t))[0, row, column])

    values = {"x_1": first(0), "x_2": first(1)}
    values |= {"x_1^2": product(0, 0), "x_1 x_2": product(0, 1), "x_2^2": product(1, 1)}
    return SDE(
        controls=controls.NONCOMMUTING,
        drift=lambda t, x: (omega * TURN + turned(t, A)[0]) @ x,
        diffusion=diffusion,
        diffusion_derivative=lambda t, x, y: diffusion(t, y),
        start=start,
        noise_dim=2,
        horizon=horizon,
        observables=monomials(*values),
        truths=moments(values, SOURCE),
        units="x dimensionless, time in the unit of the damping time",
        source=f"{SOURCE}, in a turning frame",
    )


def rotation(angle: float) -> Array:
    """Return the matrix of the rotation by an angle, shape (2, 2)."""
    return np.asarray(np.cos(angle) * np.eye(2) + np.sin(angle) * TURN)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [turning_frame]
