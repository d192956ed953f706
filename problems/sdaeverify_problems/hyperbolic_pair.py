"""Two hyperbolic sines of Gaussian processes: diagonal noise, with the first component in the drift of the second."""

from collections.abc import Callable
from functools import partial

import numpy as np

from sdaeverify import SDE, Array, Increment, ParameterError, hookimpl

from . import _controls as controls
from ._known import moments, monomials, solution
from ._sines import SOURCE, mean_cosine, mean_sine, mean_square, slope


def hyperbolic_pair(
    c: float = 1.0, b_1: float = 0.6, b_2: float = 0.6, x_1: float = 1.0, x_2: float = 0.0, horizon: float = 1.0
) -> SDE:
    """Diagonal noise, coupled by the drift: x_j = sinh y_j with dy_1 = b_1 dW_1 and dy_2 = c y_1 dt + b_2 dW_2.

    dx_1 = b_1^2 x_1/2 dt + b_1 r_1 dW_1, dx_2 = (c r_2 arsinh x_1 + b_2^2 x_2/2) dt + b_2 r_2 dW_2, with
    r_j = sqrt(1 + x_j^2). x_2 depends on the time integral of W_1, a function of dW and H.

    Parameters
    ----------
    c : float
        Coupling, unit 1/time.
    b_1 : float
        Noise amplitude of the first component, unit 1/sqrt(time).
    b_2 : float
        Noise amplitude of the second component, unit 1/sqrt(time).
    x_1 : float
        Initial value of the first component.
    x_2 : float
        Initial value of the second component.
    horizon : float
        Final time.

    Source
    ------
    Kloeden & Platen (1992), section 4.4.
    """
    b, start = np.array([[b_1], [b_2]]), np.arcsinh([x_1, x_2])
    if not (width := np.sqrt(law(start, c, b_1, b_2, horizon)[1])) <= 3.0:
        raise ParameterError(f"y_2 may have a standard deviation of 3 at the end, got {width:.3g}: x_2 is its sinh")

    def drift(t: float, x: Array) -> Array:
        along = np.stack([0.0 * x[0], c * np.arcsinh(x[0])])
        return along * slope(x) + 0.5 * b * b * x

    def advance(y: Array, t: float, h: float, noise: Increment) -> Array:
        pushed = c * (h * y[0] + b_1 * noise.time_integral(h)[0])
        return y + b * noise.dW + np.stack([0.0 * pushed, pushed])

    return SDE(
        controls=controls.WITH_AREAS,
        drift=drift,
        diffusion=lambda t, x: diagonal(b * slope(x)),
        diffusion_derivative=lambda t, x, y: diagonal(b * x * y / slope(x)),
        start=[x_1, x_2],
        noise_dim=2,
        horizon=horizon,
        traits=frozenset({"diagonal-noise"}),
        observables=monomials("x_2", "x_2^2", "x_1 x_2"),
        truths=(
            solution(start, advance, SOURCE, parts=lambda t, y: {"x": np.sinh(y)}),
            *moments(values(start, c, b_1, b_2), SOURCE),
        ),
        units="x dimensionless, time in the unit of 1/c",
        source=SOURCE,
    )


def values(start: Array, c: float, b_1: float, b_2: float) -> dict[str, Callable[[float], float]]:
    """Return the expectations of products of x_1 and x_2 as functions of time.

    Parameters
    ----------
    start : ndarray, shape (2,)
        Value of y at time 0, where x = sinh(y).
    c : float
        Drift of y_2 per unit of y_1.
    b_1, b_2 : float
        Strengths of the noises.
    """
    known = partial(law, start, c, b_1, b_2)

    def product(t: float) -> float:
        m, v, shared = known(t)
        sums = (mean_cosine(start[0] + s * m, b_1**2 * t + v + 2.0 * s * shared) for s in (1.0, -1.0))
        return 0.5 * float(np.subtract(*sums))

    return {
        "x_2": lambda t: mean_sine(*known(t)[:2]),
        "x_2^2": lambda t: mean_square(*known(t)[:2]),
        "x_1 x_2": product,
    }


def law(start: Array, c: float, b_1: float, b_2: float, t: float) -> tuple[float, float, float]:
    """Return the mean and variance of y_2, and its covariance with y_1, whose mean is constant; y is normal.

    Parameters
    ----------
    start : ndarray, shape (2,)
        Value of y at time 0.
    c : float
        Drift of y_2 per unit of y_1.
    b_1, b_2 : float
        Strengths of the noises.
    t : float
    """
    return start[1] + c * start[0] * t, b_2**2 * t + c**2 * b_1**2 * t**3 / 3.0, 0.5 * c * b_1**2 * t**2


def diagonal(entries: Array) -> Array:
    """Return diagonal matrices, shape (2, 2, P), of entries of shape (2, P)."""
    matrices: Array = np.eye(2)[..., None] * entries[:, None]
    return matrices


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [hyperbolic_pair]
