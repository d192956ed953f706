"""Geometric growth whose volatility is an algebraic component, with a time-dependent constraint."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, Increment, IndexOneSDAE, Parts, hookimpl

from ._growing import GrowingVolatility
from ._known import moments, monomials, solution

SOURCE = "Kloeden & Platen 1992, (4.2.12), with y = b(t) x"


def growing_algebraic(
    a: float = -1.0, q: float = 0.5, b: float = 0.6, growth: float = 1.0, x_0: float = 1.0, horizon: float = 1.0
) -> IndexOneSDAE:
    """Growth by a moving constraint: dx = (a x + q y) dt + y dW, 0 = b(t) x - y with b(t) = b (1 + growth t).

    Eliminating y gives dx = (a + q b(t)) x dt + b(t) x dW, so that x(t) = x_0 exp(int a + q b - b^2/2 ds + int b dW).
    The integral of b dW over a step is b(t + h) dW - b growth int (W(s) - W(t)) ds, a function of dW and H. A scheme
    that solves the constraint at a wrong time has the right y on every autonomous problem, but not on this one.

    Parameters
    ----------
    a : float
        Growth rate without y, unit 1/time.
    q : float
        Contribution of y to the growth rate, unit 1/sqrt(time).
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
    Kloeden & Platen (1992), section 4.2, (2.12), with an algebraic component.
    """
    volatility = GrowingVolatility(b, growth)

    def rate(t: float, h: float) -> float:
        """Return int_t^{t+h} (a + q b) ds, by the midpoint rule, which is exact for linear functions."""
        return h * (a + q * volatility(t + 0.5 * h))

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        return x * np.exp(rate(t, h) - 0.5 * volatility.variance(t, h) + volatility.integral(t, h, noise))

    def power(n: int) -> Callable[[float], float]:
        return lambda t: float(x_0**n * np.exp(n * rate(0.0, t) + 0.5 * n * (n - 1) * volatility.variance(0.0, t)))

    def parts_of(t: float, x: Array) -> Parts:
        return {"x": x, "y": volatility(t) * x}

    return IndexOneSDAE(
        drift=lambda t, x, y: a * x + q * y,
        diffusion=lambda t, x, y: y[:, None],
        constraint=lambda t, x, y: volatility(t) * x - y,
        solved=lambda t, x: volatility(t) * x,
        start=[x_0],
        algebraic=[b * x_0],
        noise_dim=1,
        horizon=horizon,
        observables=monomials("x", "x^2", "y"),
        truths=(
            solution(x_0, advance, SOURCE, parts=parts_of),
            *moments({"x": power(1), "x^2": power(2), "y": lambda t: volatility(t) * power(1)(t)}, SOURCE),
        ),
        units="x dimensionless, time in the unit of 1/|a|",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [growing_algebraic]
