"""Moments of pendulums without gravity, whose angle and angular velocity are Gaussian."""

import numpy as np

from sdaeverify import Array, Truth

from .._known import moments
from ..curves import _circle as circle
from ._rotor import Rotor

SOURCE = "Gaussian angle and angular velocity"


def free_moments(theta_0: float, omega_0: float, radial: float) -> tuple[Truth, ...]:
    """Return the moments without gravity; `radial` is the variance rate of the noise along r.

    theta and omega are Gaussian: with m = theta_0 + omega_0 t, E e^{i theta} = e^{im - t^3/6}.
    """

    def r(t: float) -> Array:
        return np.exp(-(t**3) / 6) * circle.normal(theta_0 + omega_0 * t)

    def v(t: float) -> Array:
        return np.exp(-(t**3) / 6) * omega_0 * circle.tangent(theta_0 + omega_0 * t) - 0.5 * t**2 * r(t)

    def mu_squared(t: float) -> float:
        variance = radial * t + t**4 / 3 + 4 / 3 * omega_0**2 * t**3
        return (omega_0**2 * t + 0.5 * t**2) ** 2 + variance

    values = {
        "r_1": lambda t: r(t)[0],
        "r_2": lambda t: r(t)[1],
        "v_1": lambda t: v(t)[0],
        "v_2": lambda t: v(t)[1],
        "|v|^2": lambda t: omega_0**2 + t,
        "|v|^4": lambda t: omega_0**4 + 6 * omega_0**2 * t + 3 * t**2,
        "mu": lambda t: omega_0**2 * t + 0.5 * t**2,
        "mu^2": mu_squared,
    }
    return moments(values, SOURCE)


def damped_moments(rotor: Rotor, theta_0: float, omega_0: float) -> tuple[Truth, ...]:
    """Return the moments without gravity, with friction gamma and noise sigma.

    theta and omega are Gaussian. With d = (1 - e^{-gamma t})/gamma and D = (1 - e^{-2 gamma t})/(2 gamma), the means
    are theta_0 + omega_0 d and omega_0 e^{-gamma t}, the variances (sigma/gamma)^2 (t - 2 d + D) and sigma^2 D, and
    the covariance is sigma^2 d^2/2. Then

        E e^{i theta} = e^{i E theta - Var theta/2},   E omega e^{i theta} = (E omega + i Cov) E e^{i theta}.
    """
    gamma, sigma = rotor.gamma, rotor.sigma

    def shares(t: float) -> tuple[float, float]:
        return -np.expm1(-gamma * t) / gamma, -np.expm1(-2 * gamma * t) / (2 * gamma)

    def rotation(t: float) -> complex:
        d, D = shares(t)
        return complex(np.exp(1j * (theta_0 + omega_0 * d) - 0.5 * (sigma / gamma) ** 2 * (t - 2 * d + D)))

    def turning(t: float) -> complex:
        return (omega_0 * np.exp(-gamma * t) + 0.5j * (sigma * shares(t)[0]) ** 2) * rotation(t)

    def speed(t: float) -> tuple[float, float]:
        return (omega_0 * np.exp(-gamma * t)) ** 2, sigma**2 * shares(t)[1]

    values = {
        "r_1": lambda t: rotation(t).imag,
        "r_2": lambda t: -rotation(t).real,
        "v_1": lambda t: turning(t).real,
        "v_2": lambda t: turning(t).imag,
        "|v|^2": lambda t: sum(speed(t)),
        "|v|^4": lambda t: speed(t)[0] ** 2 + 6 * speed(t)[0] * speed(t)[1] + 3 * speed(t)[1] ** 2,
        "mu": lambda t: rotor.kT * t + (omega_0**2 - rotor.kT) * shares(t)[1],
    }
    return moments(values, SOURCE)
