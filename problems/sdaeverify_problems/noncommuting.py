"""A linear system in the plane with two noises that do not commute."""

from collections.abc import Callable

import numpy as np
import scipy

from sdaeverify import SDE, Array, MeanSquareStability, hookimpl

from . import _controls as controls
from ._known import moments, monomials

A = np.array([[-1.0, 0.5], [-0.5, -1.0]])
B_1 = np.array([[0.6, 0.0], [0.0, -0.3]])
B_2 = np.array([[0.0, 0.4], [0.4, 0.0]])
IDENTITY = np.eye(2)
# Generator of E x x^T, flattened row by row.
GENERATOR = np.kron(A, IDENTITY) + np.kron(IDENTITY, A) + np.kron(B_1, B_1) + np.kron(B_2, B_2)
SOURCE = "linear equations of the first two moments, Arnold 1974, section 8.5"


def noncommuting(x_1: float = 1.0, x_2: float = 0.5, horizon: float = 1.0) -> SDE:
    """Linear system dx = A x dt + B_1 x dW_1 + B_2 x dW_2 with B_1 B_2 != B_2 B_1, W in R^2.

    A = [[-1, 1/2], [-1/2, -1]], B_1 = diag(0.6, -0.3), B_2 = [[0, 0.4], [0.4, 0]].

    Parameters
    ----------
    x_1 : float
        Initial value of the first component.
    x_2 : float
        Initial value of the second component.
    horizon : float
        Final time, in the unit of the damping time.

    Source
    ------
    Kloeden & Platen (1992), section 10.3, (3.13): the condition of commutativity, here violated.
    """
    start = np.array([x_1, x_2])
    square = np.outer(start, start).ravel()

    def first(row: int) -> Callable[[float], float]:
        return lambda t: float((scipy.linalg.expm(A * t) @ start)[row])

    def second(row: int, column: int) -> Callable[[float], float]:
        return lambda t: float((scipy.linalg.expm(GENERATOR * t) @ square)[2 * row + column])

    values = {"x_1": first(0), "x_2": first(1)}
    values |= {"x_1^2": second(0, 0), "x_1 x_2": second(0, 1), "x_2^2": second(1, 1)}
    return SDE(
        controls=controls.NONCOMMUTING,
        drift=lambda t, x: A @ x,
        diffusion=diffusion,
        diffusion_derivative=lambda t, x, y: diffusion(t, y),
        start=start,
        noise_dim=2,
        horizon=horizon,
        observables=monomials(*values),
        truths=(
            *moments(values, SOURCE),
            MeanSquareStability(stable=bool(np.linalg.eigvals(GENERATOR).real.max() < 0.0), source=SOURCE),
        ),
        units="x dimensionless, time in the unit of the damping time",
        source="Kloeden & Platen 1992, section 10.3",
    )


def diffusion(t: float, x: Array) -> Array:
    """Return the columns B_1 x and B_2 x, shape (2, 2, P)."""
    return np.stack([B_1 @ x, B_2 @ x], axis=1)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [noncommuting]
