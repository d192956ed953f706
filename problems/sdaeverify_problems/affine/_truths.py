"""Exact solutions and moments of Langevin dynamics with a linear drift and an affine constraint."""

from functools import cache

import numpy as np

from sdaeverify import Array, Chart, Increment, Line, Pathwise, Truth

from .._known import Observable, monomials, normal_means, normal_truths, solution
from ._langevin import AffineLangevin
from ._stiff_linear import StiffLinear

SOURCE = "variation of constants"


PRODUCTS = {"x_1": (0,), "x_2": (1,), "x_1^2": (0, 0), "x_1 x_2": (0, 1)}


def observables(given: AffineLangevin) -> dict[str, Observable]:
    """Return observables of first and second degree, with |zeta|^2 if eps is positive."""
    B, b = given.B, given.b[:, None]
    distance = {"|zeta|^2": lambda t, s: ((B.T @ s["x"] - b) ** 2).sum(axis=0)}
    return monomials(*PRODUCTS) | (distance if given.eps else {})


def truths(given: AffineLangevin, start: Array) -> tuple[Truth, ...]:
    """Return the pathwise solution, and the moments of all observables at every time and under the invariant law."""
    law, B, b = given.law(), given.B, given.b

    def at(t: float) -> tuple[Array, Array]:
        return start + law.change(t) @ (start - law.m), law.covariance(t)

    def distance(m: Array, C: Array) -> float:
        return float(((B.T @ m - b) ** 2).sum() + np.trace(B.T @ C @ B))

    means = normal_means(PRODUCTS) | ({"|zeta|^2": distance} if given.eps else {})
    return (pathwise(law, start), *normal_truths(means, at, (law.m, law.covariance()), SOURCE))


def pathwise(law: StiffLinear, start: Array) -> Pathwise:
    """Return the solution on a given Brownian path, with d additional normals per step."""
    steps = cache(law.step)

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        step = steps(h)
        integral = step.of_dW @ noise.dW + step.of_H @ noise.H + step.of_xi @ noise.xi
        return np.asarray(x + step.change @ (x - law.m[:, None]) + law.sigma * integral)

    return solution(start, advance, SOURCE, extra_normals=len(start))


def flat_chart(law: StiffLinear, directions: Array) -> Chart | None:
    """Return coordinates of x - m along orthonormal directions, shape (d, k); None if k > 2 or a scale is 0."""
    scales = np.sqrt(np.diag(directions.T @ law.covariance() @ directions))
    if len(scales) > 2 or not np.all(scales > 0.0):
        return None
    return Chart(
        axes=tuple(Line(0.0, float(scale)) for scale in scales),
        embed=lambda z: law.m[:, None] + directions @ z,
        read=lambda x: directions.T @ (x - law.m[:, None]),
    )
