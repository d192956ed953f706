"""The free pendulum with noise proportional to its velocity, so that its speed is a geometric Brownian motion."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Increment, MeanSquareStability, hookimpl

from .. import _controls as controls
from .._known import moments
from ..curves import _circle as circle


def pendulum_velocity_noise(
    sigma: float = 1.0, gamma: float = 0.0, theta_0: float = 0.5, omega_0: float = 0.5, horizon: float = 0.25
) -> HolonomicSDAE:
    """Free pendulum with noise along v: dr = v dt, dv = -gamma v dt + sigma v dW - r dmu, (1 - |r|^2)/2 = 0.

    With k = gamma + sigma^2/2, exactly

        omega = omega_0 exp(-k t + sigma W(t)),   theta = theta_0 + int_0^t omega ds,   dmu = omega^2 dt.

    |v| is exact on any grid; theta and mu are computed to order 3/2 on the reference grid.

    Parameters
    ----------
    sigma : float
        Noise amplitude, unit 1/sqrt(time).
    gamma : float
        Friction, unit 1/time.
    theta_0 : float
        Initial angle from the lowest point, radian.
    omega_0 : float
        Initial angular velocity, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Lindner & Stroot (2017), section 5.1, with B(r, v) = sigma v and a = -gamma v.
    """
    k = gamma + 0.5 * sigma**2
    source = "geometric Brownian angular velocity"

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        theta, omega, mu = z
        dtheta = omega * exponential_integral(-k, sigma, h, noise)
        dmu = omega**2 * exponential_integral(-2.0 * k, 2.0 * sigma, h, noise)
        return np.stack([theta + dtheta, omega * np.exp(-k * h + sigma * noise.dW[0]), mu + dmu])

    def mean_mu(t: float) -> float:
        rate = sigma**2 - 2 * gamma
        return omega_0**2 * (t if rate == 0.0 else np.expm1(rate * t) / rate)

    values = {
        "|v|^2": lambda t: omega_0**2 * np.exp((sigma**2 - 2 * gamma) * t),
        "|v|^4": lambda t: omega_0**4 * np.exp((6 * sigma**2 - 4 * gamma) * t),
        "mu": mean_mu,
    }
    return HolonomicSDAE(
        controls=controls.WITH_AREAS,
        force=lambda t, r, v: -gamma * v,
        diffusion=lambda t, r, v: sigma * v[:, None],
        **circle.MECHANICS,
        **circle.start(theta_0, omega_0),
        horizon=horizon,
        noise_dim=1,
        observables=circle.OBSERVABLES,
        truths=(
            circle.angle_truth(theta_0, omega_0, advance, "exact for |v|, order 3/2 for theta and mu"),
            *moments(values, source),
            MeanSquareStability(stable=sigma**2 < 2 * gamma, source=source),
        ),
        units="length of the pendulum 1, time in the unit of omega_0",
        source="Lindner & Stroot 2017, section 5.1, B(r, v) = sigma v",
    )


def exponential_integral(a: float, b: float, h: float, noise: Increment) -> Array:
    """Return int_0^h exp(a s + b W(s)) ds up to zero-mean terms of size h^2, shape (P,).

    The integral is h + b int W ds + a h^2/2 + (b^2/2) E[int W^2 ds | dW, H] + remainder.

    Parameters
    ----------
    a, b : float
        Coefficients of time and of W in the exponent.
    h : float
        Step size.
    noise : Increment
        Increment with dW and H of one Brownian motion W.
    """
    linear = b * noise.time_integral(h)[0]
    return h + linear + 0.5 * a * h**2 + 0.5 * b**2 * circle.square_integral(h, noise)[0]


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [pendulum_velocity_noise]
