"""The Ornstein-Uhlenbeck process with a periodic force, so that the drift depends on time."""

import numpy as np

from sdaeverify import SDE, Array, Increment, hookimpl

from . import _controls as controls
from . import _normal_law as normal
from ._arguments import check_positive
from ._known import constant_noise, solution
from .ou import exponential_integral


def forced_ou(
    a: float = 1.0, amplitude: float = 1.0, omega: float = 2.0, sigma: float = 0.7, horizon: float = 1.0
) -> SDE:
    """Ornstein-Uhlenbeck with a force: dx = (-a x + A cos(omega t)) dt + sigma dW, x(0) = 1.

    With p(t) = A (a cos(omega t) + omega sin(omega t))/(a^2 + omega^2), exactly,

        x(t) = p(t) + e^{-at} (x(0) - p(0)) + sigma int_0^t e^{-a(t-s)} dW(s).

    Parameters
    ----------
    a : float
        Rate, unit 1/time, positive.
    amplitude : float
        Amplitude A of the force, unit x/time.
    omega : float
        Frequency of the force, unit 1/time.
    sigma : float
        Noise amplitude, unit x/sqrt(time).
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.2) with a force: variation of constants.
    """
    check_positive(a=a)
    source = "variation of constants"

    def periodic_part(t: float) -> float:
        return float(amplitude * (a * np.cos(omega * t) + omega * np.sin(omega * t)) / (a * a + omega * omega))

    def law(t: float) -> tuple[float, float]:
        variance = -(sigma**2) * np.expm1(-2 * a * t) / (2 * a)
        return periodic_part(t) + np.exp(-a * t) * (1.0 - periodic_part(0.0)), variance

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        alpha, beta, rest = exponential_integral(a * h)
        integral = alpha * noise.dW + beta * noise.H + rest * np.sqrt(h) * noise.xi
        return periodic_part(t + h) + np.exp(-a * h) * (x - periodic_part(t)) + sigma * integral

    return SDE(
        controls=controls.ADDITIVE,
        drift=lambda t, x: amplitude * np.cos(omega * t) - a * x,
        **constant_noise(sigma),
        start=[1.0],
        horizon=horizon,
        observables=normal.OBSERVABLES,
        truths=(
            solution(1.0, advance, source, extra_normals=1),
            *normal.normal_moments(law, source),
        ),
        units="x in units of its choice, time in the unit of 1/a",
        source="Kloeden & Platen 1992, section 4.4",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [forced_ou]
