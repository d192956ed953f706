"""Expectations of a normally distributed scalar."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Truth

from ._known import limits, moments, monomials

OBSERVABLES = {**monomials("x", "x^2", "x^3"), "cos x": lambda t, s: np.cos(s["x"][0])}
MEANS: dict[str, Callable[[float, float], float]] = {
    "x": lambda m, v: m,
    "x^2": lambda m, v: m * m + v,
    "x^3": lambda m, v: m**3 + 3 * m * v,
    "cos x": lambda m, v: float(np.exp(-0.5 * v) * np.cos(m)),
}


def normal_moments(law: Callable[[float], tuple[float, float]], source: str) -> tuple[Truth, ...]:
    """Return the expectations of all observables, given mean and variance as functions of time."""

    def at(mean: Callable[[float, float], float]) -> Callable[[float], float]:
        return lambda t: mean(*law(t))

    return moments({name: at(mean) for name, mean in MEANS.items()}, source)


def normal_limits(variance: float, source: str) -> tuple[Truth, ...]:
    """Return the means of all observables under the centred invariant law of the given variance."""
    return limits({name: mean(0.0, variance) for name, mean in MEANS.items()}, source)
