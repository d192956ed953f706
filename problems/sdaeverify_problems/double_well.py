"""Overdamped motion in a double-well potential."""

import numpy as np
import scipy

from sdaeverify import SDE, Array, Chart, Increment, Line, MomentEquation, hookimpl

from . import _controls as controls
from ._arguments import check_least
from ._known import gradient_noise, limits, monomials, solution

OBSERVABLES = {**monomials("x", "x^2", "x^4"), "cos x": lambda t, s: np.cos(s["x"][0])}


def double_well(sigma: float = 1.0, x_0: float = 0.5, horizon: float = 1.0) -> SDE:
    """Motion in the potential V = x^4/4 - x^2/2: dx = (x - x^3) dt + sigma dW, invariant density ~ e^{-2 V/sigma^2}.

    Parameters
    ----------
    sigma : float
        Noise amplitude, unit x/sqrt(time), at least 0.3, because transitions between the wells are rare below.
    x_0 : float
        Initial value.
    horizon : float
        Final time, in units of the growth time at the local maximum of V.

    Source
    ------
    Pavliotis (2014), Stochastic Processes and Applications, chapter 4.
    """
    check_least(0.3, sigma=sigma)

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        """Return x after one Ito-Taylor step of strong order 3/2."""
        f, slope = x - x * x * x, 1.0 - 3.0 * x * x
        curved = 0.5 * h * h * (f * slope - 3.0 * sigma**2 * x)
        return x + f * h + sigma * noise.dW + sigma * slope * noise.time_integral(h) + curved

    means = invariant_means(sigma)
    return SDE(
        controls=controls.ADDITIVE,
        drift=lambda t, x: x - x * x * x,
        **gradient_noise(sigma),
        start=[x_0],
        horizon=horizon,
        observables=OBSERVABLES,
        truths=(
            solution(x_0, advance, "order 3/2 Ito-Taylor step", order=1.5),
            *limits(means, "quadrature"),
            MomentEquation(observable="x^2", source="virial theorem"),
        ),
        # The tails are lighter than normal: half the width concentrates the expansion on the wells.
        chart=Chart(axes=(Line(0.0, 0.5 * means["x^2"] ** 0.5),), embed=lambda z: z, read=lambda x: x),
        relaxation_time=relaxation(sigma),
        units="wells at -1 and 1, time in the unit of the growth time at the hill",
        source="Pavliotis 2014, chapter 4",
    )


def grid(sigma: float) -> Array:
    """Return equidistant points that cover the region where the invariant density exceeds e^{-40} of its maximum."""
    end = np.sqrt(1.0 + sigma * np.sqrt(80.0))
    return np.linspace(-end, end, 401)


def invariant_means(sigma: float) -> dict[str, float]:
    """Return the means of all observables by the trapezoidal rule, exact to rounding for this density."""
    x = grid(sigma)
    density = np.exp(-0.5 * ((x * x - 1.0) / sigma) ** 2)
    return {name: float(density @ q(0.0, {"x": x[None]}) / density.sum()) for name, q in OBSERVABLES.items()}


def relaxation(sigma: float) -> float:
    """Return 1/lambda for the spectral gap lambda of -(sigma^2/2) D^2 + (V'^2/sigma^2 - V'')/2.

    The operator is similar to minus the generator. Central differences on the grid give lambda to about 0.1 %.
    """
    x = grid(sigma)
    hop = 0.5 * (sigma / (x[1] - x[0])) ** 2
    well = 0.5 * ((x**3 - x) ** 2 / sigma**2 - (3.0 * x * x - 1.0))
    lowest = scipy.linalg.eigh_tridiagonal(2.0 * hop + well, np.full(400, -hop), True, "i", (0, 1))
    return float(1.0 / lowest[1])


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [double_well]
