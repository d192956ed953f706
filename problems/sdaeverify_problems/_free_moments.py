"""Snapshot of the pendulum without gravity, whose angle and angular velocity are Gaussian."""

import numpy as np

from sdaeverify import Array, Moment, Truth

from . import _circle as circle


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
    source = "Gaussian angle and angular velocity"
    return tuple(Moment(observable=name, value=value, source=source) for name, value in values.items())
