"""A spiral in the plane: complex geometric Brownian motion, driven by one Brownian motion."""

import numpy as np

from sdaeverify import SDE, Array, Increment, MeanSquareStability, hookimpl

from . import _controls as controls
from ._known import moments, monomials, solution

SOURCE = "Kloeden & Platen 1992, (4.8.10): linear equations whose matrices commute"


def spiral(
    alpha: float = -0.5, omega: float = 2.0, beta: float = 0.4, gamma: float = 0.6, horizon: float = 1.0
) -> SDE:
    """Complex growth: dz = lambda z dt + mu z dW, z(t) = exp((lambda - mu^2/2) t + mu W(t)), x = (Re z, Im z).

    Parameters
    ----------
    alpha : float
        Rate of growth, Re lambda, unit 1/time.
    omega : float
        Rate of rotation, Im lambda, unit 1/time.
    beta : float
        Noise amplitude parallel to x, Re mu, unit 1/sqrt(time).
    gamma : float
        Noise amplitude perpendicular to x, Im mu, unit 1/sqrt(time).
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.8, (8.10).
    """
    rate, strength = complex(alpha, omega), complex(beta, gamma)
    A, B = matrix(rate), matrix(strength)
    growth = 2.0 * alpha + abs(strength) ** 2
    values = {
        "x_1": lambda t: float(np.exp(rate * t).real),
        "x_2": lambda t: float(np.exp(rate * t).imag),
        "|x|^2": lambda t: float(np.exp(growth * t)),
    }

    def advance(w: Array, t: float, h: float, noise: Increment) -> Array:
        return w + pair((rate - 0.5 * strength**2) * h + strength * noise.dW[0])

    return SDE(
        controls=controls.WITH_AREAS,
        drift=lambda t, x: A @ x,
        diffusion=lambda t, x: (B @ x)[:, None],
        diffusion_derivative=lambda t, x, y: (B @ y)[:, None],
        start=[1.0, 0.0],
        noise_dim=1,
        horizon=horizon,
        observables={**monomials("x_1", "x_2"), "|x|^2": lambda t, s: s["x"][0] ** 2 + s["x"][1] ** 2},
        truths=(
            solution(np.zeros(2), advance, SOURCE, parts=lambda t, w: {"x": pair(np.exp(w[0] + 1j * w[1]))}),
            *moments(values, SOURCE),
            MeanSquareStability(stable=growth < 0.0, source=SOURCE),
        ),
        units="x dimensionless, time in its own unit",
        source=SOURCE,
    )


def matrix(z: complex) -> Array:
    """Return the real 2 x 2 matrix of the multiplication by z."""
    return np.array([[z.real, -z.imag], [z.imag, z.real]])


def pair(z: Array) -> Array:
    """Return real and imaginary parts of z, shape (P,), as an array of shape (2, P)."""
    return np.stack([z.real, z.imag])


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [spiral]
