"""Expectations of a normally distributed scalar."""

from collections.abc import Callable

import numpy as np

from sdaeverify import InvariantMean, Moment, Truth

OBSERVABLES = {
    "x": lambda t, s: s["x"][0],
    "x^2": lambda t, s: s["x"][0] ** 2,
    "x^3": lambda t, s: s["x"][0] ** 3,
    "cos x": lambda t, s: np.cos(s["x"][0]),
}
MEANS: dict[str, Callable[[float, float], float]] = {
    "x": lambda m, v: m,
    "x^2": lambda m, v: m * m + v,
    "x^3": lambda m, v: m**3 + 3 * m * v,
    "cos x": lambda m, v: float(np.exp(-0.5 * v) * np.cos(m)),
}


def moments(law: Callable[[float], tuple[float, float]], source: str) -> tuple[Truth, ...]:
    """Return the expectations of all observables, from mean and variance as a function of time."""
    return tuple(Moment(observable=name, value=at(mean, law), source=source) for name, mean in MEANS.items())


def limits(variance: float, source: str) -> tuple[Truth, ...]:
    """Return the means of all observables under the centred invariant law."""
    return tuple(
        InvariantMean(observable=name, value=mean(0.0, variance), source=source) for name, mean in MEANS.items()
    )


def at(
    mean: Callable[[float, float], float], law: Callable[[float], tuple[float, float]]
) -> Callable[[float], float]:
    """Return an expectation as a function of time."""
    return lambda t: mean(*law(t))
