"""A nonlinear constraint without attached solution formula, although x has a closed form."""

import numpy as np

from sdaeverify import Array, DelaySDAE, Partials, Parts, hookimpl

from ._known import monomials, solution
from .gbm import exponential, powers

SOURCE = "Kloeden & Platen 1992, (4.4.6), in the variable of a cubic constraint"


def nonlinear_constraint(a: float = -1.0, b: float = 0.5, tau: float = 0.3, horizon: float = 1.0) -> DelaySDAE:
    """Cubic constraint: dx = a z dt + b z dW, z = y + y^3 + v/2, 0 = y + y^3 - x + v/2, v(t) = x(t - tau).

    The constraint implies z = x, so that x(t) = exp((a - b^2/2) t + b W(t)); x = 1 for t <= 0. Schemes find y by
    Newton's method; without delay y is known in closed form.

    Parameters
    ----------
    a : float
        Growth rate, unit 1/time.
    b : float
        Volatility, unit 1/sqrt(time).
    tau : float
        Delay, in the unit of time; 0 for none.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.6), behind a constraint of index 1.
    """

    def combine(v: Array, y: Array) -> Array:
        # y**3 would take as long as the rest of a step.
        sum_of_both: Array = y + y * y * y + 0.5 * v
        return sum_of_both

    def scaled_partials(factor: float, by_x: float, y: Array) -> Partials:
        shape = (1, *y.shape)
        return Partials(np.full(shape, by_x), np.full(shape, 0.5 * factor), factor * (1.0 + 3.0 * y**2)[None])

    def parts_of(t: float, x: Array) -> Parts:
        return {"x": x, "y": cubic_root(0.5 * x)}

    return DelaySDAE(
        drift=lambda t, x, v, y: a * combine(v, y),
        diffusion=lambda t, x, v, y: b * combine(v, y)[:, None],
        constraint=lambda t, x, v, y: combine(v, y) - x,
        drift_partials=lambda t, x, v, y: scaled_partials(a, 0.0, y),
        constraint_partials=lambda t, x, v, y: scaled_partials(1.0, -1.0, y),
        delay=tau,
        history=lambda t: [1.0],
        algebraic=1,
        noise_dim=1,
        noise=frozenset({"dW"}),
        horizon=horizon,
        observables=monomials("x", "x^2", "x^3"),
        truths=(
            *(() if tau else (solution(1.0, exponential(a, b), SOURCE, parts=parts_of),)),
            *powers(1.0, a, b),
        ),
        units="x and y dimensionless, time in the unit of 1/|a|",
        source=SOURCE,
    )


def cubic_root(p: Array) -> Array:
    """Return the real solution y of y + y^3 = p."""
    scale = np.sqrt(3.0)
    return np.asarray(2.0 / scale * np.sinh(np.arcsinh(1.5 * scale * p) / 3.0))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [nonlinear_constraint]
