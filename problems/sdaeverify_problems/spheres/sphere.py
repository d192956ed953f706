"""Brownian motion on the unit sphere."""

import numpy as np

from sdaeverify import SDE, Array, hookimpl

from .. import _controls as controls
from .._known import limits, moments, monomials
from ._unit_sphere import constraint, jacobian, squared_norm

SOURCE = "spherical harmonics: those of degree n decay at the rate n (n + 1)/2"
RELAXATION = 1.0
# Constant Jacobian Df of the drift.
SHRINKING = -np.eye(3)[..., None]


def sphere(longitude: float = 0.0, latitude: float = 0.9, horizon: float = 0.5) -> SDE:
    """Brownian motion on S^2: dX = P(X) o dW = -X dt + P(X) dW, P(x) = Id - x x^T/|x|^2, |X| = 1, W in R^3.

    Parameters
    ----------
    longitude : float
        Initial longitude, radian.
    latitude : float
        Initial latitude, radian.
    horizon : float
        Final time, in units in which the mean squared distance from the start initially grows at rate 2.

    Source
    ------
    Hsu (2002), Stochastic Analysis on Manifolds, chapter 3: projected Brownian motion of the embedding space.
    """
    start = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])

    values = {f"x_{row + 1}": lambda t, row=row: np.exp(-t) * start[row] for row in range(3)}
    values |= {
        "x_3^2": lambda t: 1 / 3 + np.exp(-3 * t) * (start[2] ** 2 - 1 / 3),
        "x_1 x_3": lambda t: np.exp(-3 * t) * start[0] * start[2],
    }
    return SDE(
        controls=controls.GENERAL,
        drift=lambda t, x: -x,
        drift_derivative=lambda t, x: SHRINKING,
        diffusion=projector,
        start=start,
        constraint=constraint,
        jacobian=jacobian,
        noise_dim=3,
        horizon=horizon,
        noise=frozenset({"dW"}),
        observables=monomials(*values),
        truths=(
            *moments(values, SOURCE),
            *limits({"x_1": 0.0, "x_2": 0.0, "x_3": 0.0, "x_3^2": 1 / 3, "x_1 x_3": 0.0}, "uniform law"),
        ),
        relaxation_time=RELAXATION,
        units="radius 1, time so that the noise has unit strength",
        source="Hsu 2002, chapter 3",
    )


def projector(t: float, x: Array) -> Array:
    """Return Id - x x^T/|x|^2, shape (3, 3, P)."""
    return np.eye(3)[..., None] - x[:, None] * x[None] / squared_norm(x)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [sphere]
