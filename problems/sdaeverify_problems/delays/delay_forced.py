"""An index-1 delay equation whose constraint depends on time, with a force manufactured for a known solution."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, DelaySDAE, Moment, Partials, hookimpl

from .._arguments import check_positive
from .._known import matrix, moments, monomials
from ._linear_delay import MOMENTS, delay_moments
from ._scalar_delay import ScalarDelay

SOURCE = "the delayed Ornstein-Uhlenbeck process, Kuchler & Mensch 1992, with a periodic function added"


def delay_forced(  # noqa: PLR0913, PLR0917 - the coefficients of two equations
    a: float = -1.0,
    B: float = -1.0,
    q: float = 0.5,
    amplitude: float = 0.6,
    omega: float = 3.0,
    sigma: float = 0.7,
    tau: float = 1.0,
    horizon: float = 2.0,
) -> DelaySDAE:
    """Delay with a forced constraint: dx = (a x + y) dt + sigma dW, 0 = q x + B v + s(t) - y, v(t) = x(t - tau).

    With A = a + q and p(t) = amplitude sin(omega t), the force s(t) = p'(t) - A p(t) - B p(t - tau) makes x - p the
    solution of dX = (A X + B X(t - tau)) dt + sigma dW, X = 1 for t <= 0, whose moments are known; x is normal. A
    scheme that solves the constraint at a wrong time has the right y on autonomous problems, but not on this one.

    Parameters
    ----------
    a : float
        Rate, unit 1/time.
    B : float
        Rate of the delayed force, unit 1/time.
    q : float
        Contribution of y to the rate, unit 1/time.
    amplitude : float
        Amplitude of the periodic part of x.
    omega : float
        Frequency of the periodic part of x, unit 1/time.
    sigma : float
        Noise amplitude, unit x/sqrt(time).
    tau : float
        Delay, positive.
    horizon : float
        Final time.

    Source
    ------
    Kuchler & Mensch (1992), section 2, for the process without force.
    """
    check_positive(tau=tau)

    def periodic(t: float) -> float:
        return float(amplitude * np.sin(omega * t))

    def force(t: float) -> float:
        return float(amplitude * omega * np.cos(omega * t)) - (a + q) * periodic(t) - B * periodic(t - tau)

    def solved(t: float, x: Array, v: Array) -> Array:
        return np.asarray(q * x + B * v + force(t))

    free = ScalarDelay(a + q, B, 0.0, 0.0, sigma, tau, 1.0, 0.0)
    return DelaySDAE(
        drift=lambda t, x, v, y: a * x + y,
        diffusion=lambda t, x, v, y: np.full((1, 1, 1), sigma),
        constraint=lambda t, x, v, y: solved(t, x, v) - y,
        solved=solved,
        drift_partials=lambda t, x, v, y: Partials(matrix(a, x), matrix(0.0, x), matrix(1.0, x)),
        constraint_partials=lambda t, x, v, y: Partials(matrix(q, x), matrix(B, x), matrix(-1.0, x)),
        delay=tau,
        history=lambda t: [1.0 + periodic(t)],
        algebraic=1,
        noise_dim=1,
        noise=frozenset({"dW"}),
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables=monomials("x", "x^2", "x^3", "y"),
        truths=_moments(free, horizon, periodic, lambda t, x, v: q * x + B * v + force(t)),
        units="x in units of its choice, time in the unit of 1/|B|",
        source=SOURCE,
    )


def _moments(
    free: ScalarDelay,
    horizon: float,
    periodic: Callable[[float], float],
    solved: Callable[[float, float, float], float],
) -> tuple[Moment, ...]:
    """Return the moments of x = X + p, which is normal, and of the y that solves the constraint."""
    if not (known := delay_moments(free, horizon)):
        return ()
    mean_of, second_of = (moment.value for moment in known)

    def mean(t: float) -> float:
        return periodic(t) + (mean_of(t) if t > 0.0 else free.x_0)

    def variance(t: float) -> float:
        return second_of(t) - mean_of(t) ** 2

    values = {
        "x": mean,
        "x^2": lambda t: mean(t) ** 2 + variance(t),
        "x^3": lambda t: mean(t) ** 3 + 3.0 * mean(t) * variance(t),
        "y": lambda t: solved(t, mean(t), mean(t - free.tau)),
    }
    return moments(values, MOMENTS)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_forced]
