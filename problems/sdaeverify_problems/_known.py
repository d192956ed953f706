"""Common parts of problems: products of components as observables, and truths of one source."""

import re
from collections.abc import Callable, Mapping
from functools import reduce
from operator import mul
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sdaeverify import Array, Increment, InvariantMean, Moment, Parts, Pathwise

Observable = Callable[[float, Parts], Array]
FACTOR = re.compile(r"([a-z]+)(?:_(\d+))?(?:\^(\d+))?")


def monomials(*names: str) -> dict[str, Observable]:
    """Return observables that are products of powers, by their names.

    Parameters
    ----------
    *names : str
        For example ``x^2``, the square of the first component of x, or ``r_1 v_2``.
    """
    return {name: monomial(name) for name in names}


def monomial(name: str) -> Observable:
    """Return an observable of `monomials` by its name."""
    factors = [FACTOR.fullmatch(word).groups("1") for word in name.split()]  # type: ignore[union-attr]
    places = [(part, int(row) - 1, int(power)) for part, row, power in factors]

    def value(t: float, s: Parts) -> Array:
        return reduce(mul, (s[part][row] if power == 1 else s[part][row] ** power for part, row, power in places))

    return value


def constant_noise(sigma: float) -> dict[str, Any]:
    """Return the fields of an SDE dx = f dt + sigma dW of one component."""
    return {
        "diffusion": lambda t, x: np.full((1, 1, 1), sigma),
        "diffusion_derivative": lambda t, x, y: np.zeros((1, 1, 1)),
        "noise_dim": 1,
        "traits": frozenset({"additive-noise", "diagonal-noise"}),
    }


def gradient_noise(sigma: float) -> dict[str, Any]:
    """Return `constant_noise` with the trait of a gradient drift, which every drift f(x) in one dimension has."""
    noise = constant_noise(sigma)
    return {**noise, "traits": noise["traits"] | {"overdamped-gradient"}}


def matrix(value: float, x: Array) -> Array:
    """Return a number as a matrix on every path of x, shape (1, 1, P)."""
    return np.full((1, 1, x.shape[-1]), value)


def moments(values: Mapping[str, Callable[[float], float]], source: str) -> tuple[Moment, ...]:
    """Return expectations, functions of time, as truths."""
    return tuple(Moment(observable=name, value=value, source=source) for name, value in values.items())


def limits(values: Mapping[str, float], source: str) -> tuple[InvariantMean, ...]:
    """Return means under the invariant law as truths."""
    return tuple(InvariantMean(observable=name, value=value, source=source) for name, value in values.items())


Law = Callable[[Array, Array], float]


def normal_means(products: Mapping[str, tuple[int, ...]]) -> dict[str, Law]:
    """Return expectations of components and of products of two under a normal law of mean m and covariance C.

    Parameters
    ----------
    products : mapping of str to tuple of int
        One or two rows that are multiplied, by name.
    """

    def expectation(i: int, j: int | None = None) -> Law:
        return lambda m, C: m[i] if j is None else m[i] * m[j] + C[i, j]

    return {name: expectation(*rows) for name, rows in products.items()}


def normal_truths(
    means: Mapping[str, Law],
    law: Callable[[float], tuple[Array, Array]],
    limit: tuple[Array, Array],
    source: str,
) -> tuple[Moment | InvariantMean, ...]:
    """Return the moments and invariant means of a normal law as truths.

    Parameters
    ----------
    means : mapping of str to callable
        Expectation of each observable as a function of mean and covariance.
    law : callable, t -> mean and covariance
    limit : tuple of ndarray
        Mean and covariance of the invariant law.
    source : str
    """

    def at(mean: Law) -> Callable[[float], float]:
        return lambda t: float(mean(*law(t)))

    values = {name: float(mean(*limit)) for name, mean in means.items()}
    return (*moments({name: at(mean) for name, mean in means.items()}, source), *limits(values, source))


def solution(
    start: ArrayLike, advance: Callable[[Array, float, float, Increment], Array], source: str, **further: Any
) -> Pathwise:
    """Return the solution on a path from a fixed initial state.

    Parameters
    ----------
    start : float or array_like, shape (k,)
        State at time 0.
    advance : callable, (z, t, h, noise) -> ndarray, shape (k, P)
    source : str
    **further
        Other fields of `Pathwise`; by default `parts` makes the state the component x.
    """
    column = np.array(start, dtype=float).reshape(-1, 1)
    fields: dict[str, Any] = {"parts": lambda t, x: {"x": x}, **further}
    return Pathwise(start=lambda paths: np.repeat(column, paths, axis=1), advance=advance, source=source, **fields)
