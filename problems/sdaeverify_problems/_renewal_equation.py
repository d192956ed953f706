"""The second moment of a scalar linear delay equation, by its renewal equation.

With r' = A r + B r(t - tau), r(0) = 1, r = 0 before 0, the noise g = c x + d v + s enters as
x(t) = m(t) + int_0^t r(t - q) g(q) dW(q). Hence gamma = E g^2 obeys a renewal equation, and E x^2 follows,

    gamma(t) = (c m(t) + d m(t - tau) + s)^2 + int_0^t [c r(t - q) + d r(t - tau - q)]^2 gamma(q) dq,
    E x(t)^2 = m(t)^2 + int_0^t r(t - q)^2 gamma(q) dq.

Between multiples of tau all functions are analytic, and the equation is solved by collocation there. (The pieces
x(s), x(s + tau), ... obey equations with independent noises, but a younger one begins where an older one ends: the
older one's noise is known to it, and their joint moments obey no closed equation in s.)
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from sdaeverify import Array

from ._scalar_delay import ScalarDelay, mean, piece

# A function of the number of its piece, counted from 0, and of the time since the piece began.
Pieces = Callable[[int, Array], Array]


def second(equation: ScalarDelay, t: float) -> float:
    """Return E x(t)^2."""
    k, u = piece(equation, t)
    past = sum(_weights(equation, equation.square, k - j, u) @ intensity(equation, j) for j in range(k + 1))
    return float(mean(equation, k, u) ** 2 + past)


@cache
def intensity(equation: ScalarDelay, k: int) -> Array:
    """Return gamma at the nodes of a piece."""
    c, d, s, times = equation.c, equation.d, equation.s, _times(equation)
    drawn = [c * mean(equation, k, u) + d * mean(equation, k - 1, u) + s for u in times]
    older = [_rows(equation, k - j) @ intensity(equation, j) for j in range(k)]
    return np.asarray(np.linalg.solve(np.eye(len(times)) - _rows(equation, 0), np.square(drawn) + sum(older)))


@cache
def _rows(equation: ScalarDelay, k: int) -> Array:
    return np.stack([_weights(equation, equation.kernel, k, u) for u in _times(equation)])


def _times(equation: ScalarDelay) -> list[float]:
    return [float(x) for x in 0.5 * equation.tau * (1.0 + _basis(equation.points).x)]


def _weights(equation: ScalarDelay, kernel: Pieces, k: int, u: float) -> Array:
    """Return the weights of gamma's values on a piece in the integral over it at time u of the k-th piece after."""
    tau = equation.tau
    row = _integral(equation, lambda q: kernel(k, u - q), 0.0, u)
    return row if not k else row + _integral(equation, lambda q: kernel(k - 1, tau + u - q), u, tau)


def _integral(equation: ScalarDelay, weight: Callable[[Array], Array], low: float, high: float) -> Array:
    x, w, inverse = _basis(equation.points)
    half = 0.5 * (high - low)
    q = low + half * (1.0 + x)
    return np.asarray(half * w * weight(q) @ legvander(2.0 * q / equation.tau - 1.0, len(x) - 1) @ inverse)


class _Basis(NamedTuple):
    """Gauss' rule on [-1, 1], and the matrix that takes values at its nodes to Legendre coefficients."""

    x: Array
    w: Array
    inverse: Array


@cache
def _basis(nodes: int) -> _Basis:
    x, w = leggauss(nodes)
    return _Basis(x, w, np.linalg.inv(legvander(x, nodes - 1)))
