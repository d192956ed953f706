"""Geometric Brownian motion whose drift contains an algebraic component."""

from sdaeverify import Array, DelaySDAE, MeanSquareStability, Partials, Parts, hookimpl

from ._known import matrix, monomials, solution
from .gbm import exponential, powers

SOURCE = "Kloeden & Platen 1992, (4.4.6), with y = q x"


def gbm_algebraic(
    a: float = -1.0, b: float = 0.6, q: float = 0.5, tau: float = 0.0, x_0: float = 1.0, horizon: float = 1.0
) -> DelaySDAE:
    """Geometric growth with y: dx = (a x + y) dt + b x dW, 0 = q x - y; x(t) = x_0 exp((a + q - b^2/2) t + b W(t)).

    Parameters
    ----------
    a : float
        Growth rate without y, unit 1/time.
    b : float
        Volatility, unit 1/sqrt(time).
    q : float
        Contribution of y to the growth rate, unit 1/time.
    tau : float
        Delay, in the unit of time; no coefficient depends on the delayed state.
    x_0 : float
        Value at all times up to 0.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.6), with an algebraic component.
    """
    A = a + q

    def parts_of(t: float, x: Array) -> Parts:
        return {"x": x, "y": q * x}

    return DelaySDAE(
        drift=lambda t, x, v, y: a * x + y,
        diffusion=lambda t, x, v, y: b * x[:, None],
        constraint=lambda t, x, v, y: q * x - y,
        solved=lambda t, x, v: q * x,
        drift_partials=lambda t, x, v, y: Partials(matrix(a, x), matrix(0.0, x), matrix(1.0, x)),
        constraint_partials=lambda t, x, v, y: Partials(matrix(q, x), matrix(0.0, x), matrix(-1.0, x)),
        delay=tau,
        history=lambda t: [x_0],
        algebraic=[q * x_0],
        noise_dim=1,
        noise=frozenset({"dW"}),
        horizon=horizon,
        observables=monomials("x", "x^2", "x^3"),
        truths=(
            solution(x_0, exponential(A, b), SOURCE, parts=parts_of),
            *powers(x_0, A, b),
            MeanSquareStability(stable=2.0 * A + b * b < 0.0, source=SOURCE),
        ),
        units="x dimensionless, time in the unit of 1/|a|",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [gbm_algebraic]
