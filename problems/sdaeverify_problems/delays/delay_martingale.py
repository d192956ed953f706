"""A martingale whose noise is proportional to its own past."""

from sdaeverify import DelaySDAE, hookimpl

from .._arguments import check_positive
from ._linear_delay import linear_delay
from ._scalar_delay import ScalarDelay


def delay_martingale(d: float = 0.8, tau: float = 1.0, horizon: float = 2.0) -> DelaySDAE:
    """Delayed martingale: dx = d x(t - tau) dW, x = 1 for t <= 0.

    E x = 1, and E x^2 is a polynomial of degree k + 1 on [k tau, (k + 1) tau], 1 + d^2 t for k = 0. Up to tau,
    Euler's method has no error, and with tau = m h, E (x_N - x(t_N))^2 = d^4 (t_N - tau) h/2 up to 2 tau.

    Parameters
    ----------
    d : float
        Noise amplitude, unit 1/sqrt(time).
    tau : float
        Delay, positive.
    horizon : float
        Final time.

    Notes
    -----
    E x and E x^2 are attached for up to 2000 delays within the horizon, some hundreds where the equation is stiff.

    Source
    ------
    Ito's isometry, interval by interval.
    """
    check_positive(tau=tau)
    return linear_delay(
        ScalarDelay(0.0, 0.0, 0.0, d, 0.0, tau, 1.0, 0.0),
        horizon=horizon,
        traits=frozenset({"delayed-noise"}),
        units="x dimensionless, time in the unit of 1/d^2",
        source="Ito's isometry",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_martingale]
