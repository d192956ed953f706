"""Geometric Brownian motion."""

import numpy as np

from sdaeverify import SDE, Array, Increment, MeanSquareStability, Moment, Pathwise, hookimpl


def gbm(a: float = 0.5, b: float = 0.6, x_0: float = 1.0, horizon: float = 1.0) -> SDE:
    """Geometric growth: dx = a x dt + b x dW, x(t) = x_0 exp((a - b^2/2) t + b W(t)).

    Parameters
    ----------
    a : float
        Growth rate, unit 1/time.
    b : float
        Volatility, unit 1/sqrt(time).
    x_0 : float
        Initial value.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.6).
    """
    source = "Kloeden & Platen 1992, (4.4.6)"

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        return x * np.exp((a - 0.5 * b * b) * h + b * noise.dW)

    return SDE(
        drift=lambda t, x: a * x,
        diffusion=lambda t, x: b * x[:, None],
        diffusion_derivative=lambda t, x, y: b * y[:, None],
        start=[x_0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"diagonal-noise"}),
        noise=frozenset({"dW"}),
        observables={"x": lambda t, s: s["x"][0], "x^2": lambda t, s: s["x"][0] ** 2},
        truths=(
            Pathwise(
                start=lambda paths: np.full((1, paths), x_0),
                advance=advance,
                parts=lambda t, x: {"x": x},
                source=source,
            ),
            Moment(observable="x", value=lambda t: x_0 * np.exp(a * t), source=source),
            Moment(observable="x^2", value=lambda t: x_0**2 * np.exp((2 * a + b * b) * t), source=source),
            MeanSquareStability(stable=2 * a + b * b < 0, source=source),
        ),
        units="x dimensionless, time in the unit of 1/a",
        source=source,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [gbm]
