"""Two components with a delay, two noises that do not commute, and two time-dependent algebraic components."""

import numpy as np

from sdaeverify import Array, DelaySDAE, Partials, hookimpl, in_matrix

from .._arguments import check_positive
from .._brief import DELAYED
from .._known import monomials

A, B = np.array([[-1.0, 0.4], [-0.3, -0.8]]), np.array([[0.5, -0.2], [0.3, 0.4]])
# Coefficients of y, x and the lagged x in the constraint.
C, D, E = (
    np.array([[1.0, 0.3], [-0.2, 0.9]]),
    np.array([[0.4, 0.1], [-0.2, 0.3]]),
    np.array([[0.2, -0.3], [0.1, 0.2]]),
)
NOISES = np.array([[[0.4, 0.1], [0.0, 0.2]], [[0.2, -0.2], [0.3, 0.1]]])


@in_matrix({}, schemes=DELAYED, measures=("drift", "weak"))
def delay_pair(sigma: float = 0.5, tau: float = 0.37, omega: float = 3.0, horizon: float = 1.0) -> DelaySDAE:
    """Delayed pair: dx = (A x + B sin(v) + y) dt + sigma (G_j x + e_j) dW_j, 0 = C y - D x - E v - s(t).

    v = x(t - tau). All matrices are full, G_1 and G_2 do not commute, and s(t) = (sin(omega t), cos(omega t))/2. The
    delay is not a multiple of the step size, and x = (1 + t, 1/2 - t^2) for t <= 0.

    Parameters
    ----------
    sigma : float
        Noise amplitude, unit 1/sqrt(time).
    tau : float
        Delay, positive.
    omega : float
        Frequency of the force, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Qu, Huang & Liu (2010), (2.1), with coefficients in whose equations no term vanishes.
    """
    check_positive(tau=tau)

    def follow(t: float, x: Array, v: Array) -> Array:
        force = 0.5 * np.array([[np.sin(omega * t)], [np.cos(omega * t)]])
        return np.asarray(D @ x + E @ v + force)

    return DelaySDAE(
        drift=lambda t, x, v, y: A @ x + B @ np.sin(v) + y,
        diffusion=lambda t, x, v, y: sigma * (np.einsum("jik,kp->ijp", NOISES, x) + np.eye(2)[..., None]),
        constraint=lambda t, x, v, y: C @ y - follow(t, x, v),
        solved=lambda t, x, v: np.linalg.solve(C, follow(t, x, v)),
        drift_partials=lambda t, x, v, y: Partials(_whole(A, x), B[..., None] * np.cos(v), _whole(np.eye(2), x)),
        constraint_partials=lambda t, x, v, y: Partials(_whole(-D, x), _whole(-E, x), _whole(C, x)),
        delay=tau,
        history=lambda t: [1.0 + t, 0.5 - t * t],
        algebraic=2,
        noise_dim=2,
        horizon=horizon,
        observables=monomials("x_1", "x_2^2", "y_1"),
        units="x dimensionless, time in the unit of the rates",
        source="Qu, Huang & Liu 2010, (2.1), for two components",
    )


def _whole(matrix: Array, x: Array) -> Array:
    """Return a matrix broadcast to every path, shape (2, 2, P)."""
    return np.asarray(np.broadcast_to(matrix[..., None], (2, 2, x.shape[-1])))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_pair]
