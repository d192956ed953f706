"""Geometric Brownian motion: with moderate growth, with heavy tails, and as the linear test equation."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Array, Domain, Increment, MeanSquareStability, Moment, hookimpl

from . import _controls as controls
from ._known import moments, monomials, solution

SOURCE = "Kloeden & Platen 1992, (4.4.6)"


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
    return SDE(
        controls=controls.SCALAR,
        drift=lambda t, x: a * x,
        diffusion=lambda t, x: b * x[:, None],
        diffusion_derivative=lambda t, x, y: b * y[:, None],
        start=[x_0],
        noise_dim=1,
        horizon=horizon,
        domain=Domain.orthant() if x_0 >= 0.0 else None,
        traits=frozenset({"diagonal-noise"}),
        noise=frozenset({"dW"}),
        observables=monomials("x", "x^2", "x^3"),
        truths=(
            solution(x_0, exponential(a, b), SOURCE),
            *powers(x_0, a, b),
            MeanSquareStability(stable=2 * a + b * b < 0, source=SOURCE),
        ),
        units="x dimensionless, time in the unit of 1/a",
        source=SOURCE,
    )


def gbm_heavy(x_0: float = 1.0, horizon: float = 1.0) -> SDE:
    """Geometric growth with heavy tails: dx = 2 x dt + x dW.

    Parameters
    ----------
    x_0 : float
        Initial value.
    horizon : float
        Final time, in units in which the growth rate is 2.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.6).
    """
    return gbm(2.0, 1.0, x_0, horizon)


def linear_test(a: float = -2.0, b: float = 1.0, x_0: float = 1.0, horizon: float = 1.0) -> SDE:
    """Linear test equation of mean-square stability: dx = a x dt + b x dW, stable if and only if 2a + b^2 < 0.

    Parameters
    ----------
    a : float
        Rate, unit 1/time.
    b : float
        Volatility, unit 1/sqrt(time).
    x_0 : float
        Initial value.
    horizon : float
        Final time.

    Source
    ------
    Higham (2000); Saito & Mitsui (1996).
    """
    return gbm(a, b, x_0, horizon)


def exponential(a: float, b: float) -> Callable[[Array, float, float, Increment], Array]:
    """Return the exact step of x(t) = x_0 exp((a - b^2/2) t + b W(t))."""
    return lambda x, t, h, noise: x * np.exp((a - 0.5 * b * b) * h + b * noise.dW)


def powers(x_0: float, a: float, b: float) -> tuple[Moment, ...]:
    """Return the moments E x^n = x_0^n exp([n a + n (n - 1) b^2/2] t) for n = 1, 2, 3.

    Parameters
    ----------
    x_0 : float
        Initial value.
    a, b : float
        Rates of drift and noise: dx = a x dt + b x dW.
    """

    def power(n: int) -> Callable[[float], float]:
        rate = n * a + 0.5 * n * (n - 1) * b * b
        return lambda t: x_0**n * np.exp(rate * t)

    return moments({"x": power(1), "x^2": power(2), "x^3": power(3)}, SOURCE)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problems."""
    return [gbm, gbm_heavy, linear_test]
