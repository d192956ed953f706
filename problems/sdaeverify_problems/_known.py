"""What many problems have in common: products of components as observables, and truths of one source."""

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
        x^2 is the square of the first component of x, r_1 v_2 a product of two others.
    """
    return {name: monomial(name) for name in names}


def monomial(name: str) -> Observable:
    """Return one of `monomials`."""
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
    """Return the same where the drift does not depend on time: every drift of one component is a gradient."""
    noise = constant_noise(sigma)
    return {**noise, "traits": noise["traits"] | {"overdamped-gradient"}}


def matrix(value: float, x: Array) -> Array:
    """Return a number as a matrix on every path of x, shape (1, 1, P)."""
    return np.full((1, 1, x.shape[-1]), value)


def moments(values: Mapping[str, Callable[[float], float]], source: str) -> tuple[Moment, ...]:
    """Return expectations as functions of time, by observable."""
    return tuple(Moment(observable=name, value=value, source=source) for name, value in values.items())


def limits(values: Mapping[str, float], source: str) -> tuple[InvariantMean, ...]:
    """Return means under the invariant law, by observable."""
    return tuple(InvariantMean(observable=name, value=value, source=source) for name, value in values.items())


Law = Callable[[Array, Array], float]


def normal_means(products: Mapping[str, tuple[int, ...]]) -> dict[str, Law]:
    """Return the expectations of components and of products of two, of mean m and covariance C.

    Parameters
    ----------
    products : mapping of str to tuple of int
        By name, the rows that are multiplied, one or two.
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
    """Return what is known of a normal law.

    Parameters
    ----------
    means : mapping of str to callable
        The expectation of each observable, of mean and covariance.
    law : callable, t -> mean and covariance
    limit : tuple of ndarray
        Mean and covariance in the long run.
    source : str
    """

    def at(mean: Law) -> Callable[[float], float]:
        return lambda t: float(mean(*law(t)))

    values = {name: float(mean(*limit)) for name, mean in means.items()}
    return (*moments({name: at(mean) for name, mean in means.items()}, source), *limits(values, source))


def solution(
    start: ArrayLike, advance: Callable[[Array, float, float, Increment], Array], source: str, **further: Any
) -> Pathwise:
    """Return the solution on a path, from a point.

    Parameters
    ----------
    start : float or array_like, shape (k,)
        Its state at time 0.
    advance : callable, (z, t, h, noise) -> ndarray, shape (k, P)
    source : str
    **further
        Other fields; without `parts` the state is the component x.
    """
    column = np.array(start, dtype=float).reshape(-1, 1)
    fields: dict[str, Any] = {"parts": lambda t, x: {"x": x}, **further}
    return Pathwise(start=lambda paths: np.repeat(column, paths, axis=1), advance=advance, source=source, **fields)
