"""Geometric Brownian motion whose volatility grows linearly in time."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Array, Increment, hookimpl

from . import _controls as controls
from ._growing import GrowingVolatility
from ._known import moments, monomials, solution

SOURCE = "Kloeden & Platen 1992, (4.2.12): linear equations with coefficients that depend on time"


def growing_volatility(
    a: float = 0.5, b: float = 0.4, growth: float = 1.0, x_0: float = 1.0, horizon: float = 1.0
) -> SDE:
    """Growth dx = a x dt + b(t) x dW with b(t) = b (1 + growth t), x(t) = x_0 exp(a t - int b^2/2 + int b dW).

    The integral of b dW over a step is b(t + h) dW - b growth int (W(s) - W(t)) ds, a function of dW and H.

    Parameters
    ----------
    a : float
        Growth rate of x, unit 1/time.
    b : float
        Volatility at the start, unit 1/sqrt(time).
    growth : float
        Relative growth rate of the volatility, unit 1/time.
    x_0 : float
        Initial value.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.2, (2.12).
    """
    volatility = GrowingVolatility(b, growth)

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        return x * np.exp(a * h - 0.5 * volatility.variance(t, h) + volatility.integral(t, h, noise))

    def power(n: int) -> Callable[[float], float]:
        return lambda t: float(x_0**n * np.exp(n * a * t + 0.5 * n * (n - 1) * volatility.variance(0.0, t)))

    return SDE(
        controls=controls.WITH_AREAS,
        drift=lambda t, x: a * x,
        diffusion=lambda t, x: volatility(t) * x[:, None],
        diffusion_derivative=lambda t, x, y: volatility(t) * y[:, None],
        start=[x_0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"diagonal-noise"}),
        observables=monomials("x", "x^2"),
        truths=(solution(x_0, advance, SOURCE), *moments({"x": power(1), "x^2": power(2)}, SOURCE)),
        units="x dimensionless, time in the unit of 1/a",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [growing_volatility]
