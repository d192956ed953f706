"""The linear test equation of mean-square stability with a delay."""

from sdaeverify import DelaySDAE, MeanSquareStability, hookimpl

from .._arguments import check_positive
from . import _equilibrium as equilibrium
from ._coefficients import Coefficients
from ._linear_delay import linear_delay
from ._scalar_delay import ScalarDelay


def delay_linear(
    A: float = -2.0, B: float = 1.0, c: float = 0.5, d: float = 0.5, tau: float = 1.0, horizon: float = 2.0
) -> DelaySDAE:
    """Linear with delay: dx = (A x + B v) dt + (c x + d v) dW, v(t) = x(t - tau), x = 1 for t <= 0.

    With r' = A r + B r(t - tau), r(0) = 1, the equation is mean-square stable if and only if r decays and
    int_0^inf (c r(t) + d r(t - tau))^2 dt < 1: for A = -2, B = 1, c = 0 and tau = 1 up to |d| = 1.7749729938.

    Parameters
    ----------
    A : float
        Rate, unit 1/time.
    B : float
        Rate of the delayed force, unit 1/time.
    c : float
        Noise amplitude, unit 1/sqrt(time).
    d : float
        Delayed noise amplitude, unit 1/sqrt(time).
    tau : float
        Delay, positive.
    horizon : float
        Final time.

    Notes
    -----
    E x and E x^2 are attached for up to 2000 delays within the horizon, some hundreds where the equation is stiff.

    Source
    ------
    Qu, Huang & Liu (2010), (5.1) without the sine.
    """
    check_positive(tau=tau)
    equation = ScalarDelay(A, B, c, d, 0.0, tau, 1.0, 0.0)
    stable = equilibrium.mean_square_stable(equation)
    return linear_delay(
        equation,
        horizon=horizon,
        truths=(MeanSquareStability(stable=stable, source="E x^2 as a renewal equation"),),
        traits=frozenset({"delayed-noise"} if c == 0.0 else set()),
        dissipation=Coefficients(A, B, c, d, 0.0, 0.0).dissipation,
        units="x dimensionless, time in the unit of 1/|A|",
        source="Qu, Huang & Liu 2010, (5.1) without the sine",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_linear]
