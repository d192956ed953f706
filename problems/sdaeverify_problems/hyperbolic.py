"""The hyperbolic sine of Brownian motion with drift: a nonlinear equation with an exact solution."""

import numpy as np

from sdaeverify import SDE, Array, Increment, hookimpl

from . import _controls as controls
from ._known import moments, monomials, solution
from ._sines import SOURCE, mean_sine, mean_square, slope


def hyperbolic(a: float = 0.5, b: float = 0.6, x_0: float = 0.5, horizon: float = 1.0) -> SDE:
    """Hyperbolic sine: dx = (a r + b^2 x/2) dt + b r dW, r = sqrt(1 + x^2), x(t) = sinh(arsinh x_0 + a t + b W(t)).

    Parameters
    ----------
    a : float
        Rate, unit 1/time.
    b : float
        Noise amplitude, unit 1/sqrt(time).
    x_0 : float
        Initial value.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4.
    """

    def mean(t: float) -> float:
        return float(np.arcsinh(x_0) + a * t)

    def advance(y: Array, t: float, h: float, noise: Increment) -> Array:
        return y + a * h + b * noise.dW

    values = {
        "x": lambda t: mean_sine(mean(t), b * b * t),
        "x^2": lambda t: mean_square(mean(t), b * b * t),
    }
    return SDE(
        controls=controls.WITH_AREAS,
        drift=lambda t, x: a * slope(x) + 0.5 * b * b * x,
        diffusion=lambda t, x: b * slope(x)[:, None],
        diffusion_derivative=lambda t, x, y: (b * x * y / slope(x))[:, None],
        start=[x_0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"diagonal-noise"}),
        observables=monomials("x", "x^2"),
        truths=(
            solution(np.arcsinh(x_0), advance, SOURCE, parts=lambda t, y: {"x": np.sinh(y)}),
            *moments(values, SOURCE),
        ),
        units="x dimensionless, time in units of 1/a",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [hyperbolic]
