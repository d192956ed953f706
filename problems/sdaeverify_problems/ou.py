"""The Ornstein-Uhlenbeck process."""

import numpy as np

from sdaeverify import SDE, Array, Chart, Increment, Line, MeanSquareStability, ParameterError, hookimpl

from . import _controls as controls
from . import _normal_law as normal
from ._known import gradient_noise, solution


def ou(a: float = 1.0, sigma: float = 0.7, x_0: float = 1.0, horizon: float = 1.0) -> SDE:
    """Ornstein-Uhlenbeck: dx = -a x dt + sigma dW, x(t) = e^{-at} x_0 + sigma int_0^t e^{-a(t-s)} dW(s).

    Parameters
    ----------
    a : float
        Rate, unit 1/time, not zero.
    sigma : float
        Noise amplitude, unit x/sqrt(time).
    x_0 : float
        Initial value.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.2).
    """
    if a == 0.0:
        raise ParameterError("a must not be zero: the process would be Brownian motion")
    source = "Kloeden & Platen 1992, (4.4.2)"

    def law(t: float) -> tuple[float, float]:
        return x_0 * np.exp(-a * t), -(sigma**2) * np.expm1(-2 * a * t) / (2 * a)

    settles, width = a > 0.0 and sigma != 0.0, abs(sigma) / np.sqrt(2 * abs(a))

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        alpha, beta, rest = exponential_integral(a * h)
        integral = alpha * noise.dW + beta * noise.H + rest * np.sqrt(h) * noise.xi
        return np.exp(-a * h) * x + sigma * integral

    return SDE(
        controls=controls.STATIONARY,
        drift=lambda t, x: -a * x,
        **gradient_noise(sigma),
        start=[x_0],
        horizon=horizon,
        observables=normal.OBSERVABLES,
        truths=(
            solution(x_0, advance, source, extra_normals=1),
            *normal.normal_moments(law, source),
            *(normal.normal_limits(width**2, source) if settles else ()),
            MeanSquareStability(stable=a > 0.0 and sigma == 0.0, source="limit sigma^2/(2a) of the variance"),
        ),
        chart=Chart(axes=(Line(0.0, width),), embed=lambda z: z, read=lambda x: x) if settles else None,
        relaxation_time=1.0 / a if settles else np.inf,
        units="x in units of its choice, time in the unit of 1/a",
        source=source,
    )


def exponential_integral(z: float) -> tuple[float, float, float]:
    """Return alpha, beta, rho of int_0^h e^{-a(h-s)} dW(s) = alpha dW + beta H + rho sqrt(h) xi, z = a h.

    (1, q - 1/2) with q = (h-s)/h are the orthogonal kernels of dW and H on [0, h]; alpha, beta and rho are the
    projections and the remainder of e^{-zq}, by a quadrature that is exact to rounding for |z| <= 4. The remainder is
    computed from its values, because the difference of variances is only of size z^4/720 and would suffer from
    cancellation.
    """
    nodes, weights = np.polynomial.legendre.leggauss(16)
    q, w = 0.5 + 0.5 * nodes, 0.5 * weights
    kernel = np.exp(-z * q)
    alpha = w @ kernel
    beta = 12.0 * (w @ (kernel * (q - 0.5)))
    remainder = kernel - alpha - beta * (q - 0.5)
    return float(alpha), float(beta), float(np.sqrt(w @ remainder**2))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [ou]
