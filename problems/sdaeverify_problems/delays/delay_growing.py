"""A delayed noise whose strength is determined by a time-dependent constraint."""

import numpy as np
from numpy.polynomial import Polynomial

from sdaeverify import DelaySDAE, Partials, hookimpl

from .._arguments import check_positive
from .._known import matrix, moments, monomials

SOURCE = "Ito's isometry, interval by interval"


def delay_growing(
    a: float = -0.5, b: float = 0.6, growth: float = 0.5, tau: float = 1.0, horizon: float = 2.0
) -> DelaySDAE:
    """Delay with growing noise: dx = a x dt + (y - x) dW, 0 = x + b(t) v - y, v(t) = x(t - tau).

    b(t) = b (1 + growth t), and x(t) = exp(a t) for t <= 0. Hence E x = exp(a t) at all times, and
    N(t) = exp(-2 a t) E x(t)^2 is 1 before 0 and then

        N(t) = 1 + exp(-2 a tau) int_0^t b(s)^2 N(s - tau) ds:   a polynomial between two multiples of tau.

    A scheme that solves the constraint at a wrong time has the right y if the constraint does not depend on time, but
    not on this problem.

    Parameters
    ----------
    a : float
        Rate, unit 1/time.
    b : float
        Noise amplitude at the start, unit 1/sqrt(time).
    growth : float
        Relative growth rate of the amplitude, unit 1/time.
    tau : float
        Delay, positive.
    horizon : float
        Final time.

    Source
    ------
    Ito's isometry, interval by interval.
    """
    check_positive(tau=tau)

    def amplitude(t: float) -> float:
        return b * (1.0 + growth * t)

    def second(t: float) -> float:
        strength = np.exp(-2.0 * a * tau) * Polynomial([b, b * growth]) ** 2
        return float(np.exp(2.0 * a * t) * _piece(strength, tau, int(t // tau))(t))

    return DelaySDAE(
        drift=lambda t, x, v, y: a * x,
        diffusion=lambda t, x, v, y: (y - x)[:, None],
        constraint=lambda t, x, v, y: x + amplitude(t) * v - y,
        solved=lambda t, x, v: x + amplitude(t) * v,
        drift_partials=lambda t, x, v, y: Partials(matrix(a, x), matrix(0.0, x), matrix(0.0, x)),
        constraint_partials=lambda t, x, v, y: Partials(matrix(1.0, x), matrix(amplitude(t), x), matrix(-1.0, x)),
        delay=tau,
        history=lambda t: [np.exp(a * t)],
        algebraic=[1.0 + b * np.exp(-a * tau)],
        noise_dim=1,
        noise=frozenset({"dW"}),
        horizon=horizon,
        observables=monomials("x", "x^2", "x^3", "y"),
        truths=moments(
            {
                "x": lambda t: float(np.exp(a * t)),
                "x^2": second,
                "y": lambda t: float(np.exp(a * t) + amplitude(t) * np.exp(a * (t - tau))),
            },
            SOURCE,
        ),
        units="x dimensionless, time in the unit of the delay",
        source=SOURCE,
    )


def _piece(strength: Polynomial, tau: float, k: int) -> Polynomial:
    """Return the polynomial N on [k tau, (k + 1) tau]."""
    before = after = Polynomial([1.0])
    for j in range(k + 1):
        last, before = after, after(Polynomial([-tau, 1.0])) if j else before
        after = last(j * tau) + (strength * before).integ(lbnd=j * tau)
    return after


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_growing]
