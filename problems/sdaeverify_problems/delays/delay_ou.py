"""The Ornstein-Uhlenbeck process with a delayed force."""

from sdaeverify import DelaySDAE, hookimpl

from .._arguments import check_positive
from .._known import limits
from . import _equilibrium as equilibrium
from ._linear_delay import linear_delay
from ._scalar_delay import ScalarDelay


def delay_ou(
    A: float = -0.5, B: float = -1.0, sigma: float = 0.7, tau: float = 1.0, x_0: float = 1.0, horizon: float = 2.0
) -> DelaySDAE:
    """Ornstein-Uhlenbeck with delay: dx = (A x + B x(t - tau)) dt + sigma dW, x = x_0 for t <= 0.

    With r' = A r + B r(t - tau), r(0) = 1, the stationary variance is sigma^2 int_0^inf r(t)^2 dt.

    Parameters
    ----------
    A : float
        Rate, unit 1/time.
    B : float
        Rate of the delayed force, unit 1/time.
    sigma : float
        Noise amplitude, unit x/sqrt(time).
    tau : float
        Delay, positive.
    x_0 : float
        Value at all times up to 0.
    horizon : float
        Final time.

    Notes
    -----
    E x and E x^2 are attached for up to 2000 delays within the horizon, some hundreds where the equation is stiff.

    Source
    ------
    Kuchler & Mensch (1992), section 2.
    """
    check_positive(tau=tau)
    source = "Kuchler & Mensch 1992: stationary solutions of affine stochastic delay equations"
    equation = ScalarDelay(A, B, 0.0, 0.0, sigma, tau, x_0, 0.0)
    decay = -equilibrium.rate(equation)
    means = {"x": 0.0, "x^2": sigma**2 * equilibrium.covariances(equation).now, "x^3": 0.0} if decay > 0.0 else {}
    return linear_delay(
        equation,
        horizon=horizon,
        truths=limits(means, source),
        traits=frozenset({"additive-noise"}),
        relaxation_time=1.0 / decay if means else float("inf"),
        units="x in arbitrary units, time in units of 1/|B|",
        source=source,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_ou]
