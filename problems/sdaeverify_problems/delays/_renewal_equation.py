"""Moments of a scalar linear delay equation: the mean by the method of steps, E x^2 by a renewal equation.

With r' = A r + B r(t - tau), r(0) = 1, r = 0 before 0, both r and the mean m are continued to the next interval by

    f(t + u) = e^(A u) f(t) + B int_0^u e^(A (u - q)) f(t - tau + q) dq,    t a multiple of tau, 0 <= u <= tau.

The noise g = c x + d v + s enters as x(t) = m(t) + int_0^t r(t - q) g(q) dW(q). Hence gamma = E g^2 obeys a renewal
equation, which determines E x^2,

    gamma(t) = (c m(t) + d m(t - tau) + s)^2 + int_0^t [c r(t - q) + d r(t - tau - q)]^2 gamma(q) dq,
    E x(t)^2 = m(t)^2 + int_0^t r(t - q)^2 gamma(q) dq.

Between multiples of tau all functions are analytic, with a layer at the left end where |A| tau is large, and the
equation is solved by collocation there. (The pieces x(s), x(s + tau), ... obey equations with independent noises, but
each piece starts at the end of the previous one and so depends on its noise: their joint moments do not satisfy a
closed equation in s.)
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ParameterError

from ._graded_panels import Convolution, convolution, grade_panels, nodes
from ._scalar_delay import ScalarDelay, piece

# Largest product of growth rate and delay for which panels are built.
MOST_GROWTH = 1e5


class Pieces(NamedTuple):
    """Functions on intervals between multiples of the delay; the first piece of r and m is that before 0.

    Attributes
    ----------
    r, m : ndarray, shape (k + 1, N + 1)
        Values at the nodes and at the right end.
    gamma : ndarray, shape (k, N)
        Values at the nodes, for intervals from 0 on.
    """

    r: Array
    m: Array
    gamma: Array


def mean(equation: ScalarDelay, t: float) -> float:
    """Return E x(t) by the method of steps."""
    k, u = piece(equation, t)
    return float(_value_later(equation, _pieces(equation, k).m, k, u))


def second(equation: ScalarDelay, t: float) -> float:
    """Return E x(t)^2 by the renewal equation."""
    k, u = piece(equation, t)
    known, (young, old) = _pieces(equation, k), _convolutions(equation, (u,))
    past = ((_row(young, known.r[1 + k - j]) + _row(old, known.r[k - j])) @ known.gamma[j] for j in range(k + 1))
    return mean(equation, t) ** 2 + float(sum(past))


def size(equation: ScalarDelay, horizon: float) -> int:
    """Return the number of unknowns up to a time; the cost of moments grows quadratically with it."""
    return (piece(equation, horizon)[0] + 1) * len(nodes(_ends(equation)))


def _row(at: Convolution, r: Array) -> Array:
    return at.matrix((at.of_s @ r[:-1]) ** 2)[0]


def _value_later(equation: ScalarDelay, m: Array, k: int, u: float) -> float:
    """Return m(k tau + u) from the values of m on the previous interval."""
    (young, _), A = _convolutions(equation, (u,)), equation.A
    drawn = young.matrix(np.exp(A * young.s)) @ m[k, :-1]
    return float((np.exp(A * u) * m[k, -1] + equation.B * drawn)[0])


def _pieces(equation: ScalarDelay, k: int) -> Pieces:
    """Return the pieces up to number k or more; counts are rounded up to powers of two for the cache."""
    return _compute_pieces(equation, 1 << k.bit_length())


@cache
def _compute_pieces(equation: ScalarDelay, count: int) -> Pieces:
    A, B, c, d, s, tau, x_0, _ = equation
    u = np.append(nodes(_ends(equation)), tau)
    young, old = _convolutions(equation, tuple(u))
    step, decay = B * young.matrix(np.exp(A * young.s)), np.exp(A * u)
    r, m = [np.append(np.zeros(len(u) - 1), 1.0)], [np.append(equation.past(u[:-1] - tau), x_0)]
    for _ in range(count):
        for pieces in (r, m):
            pieces.append(decay * pieces[-1][-1] + step @ pieces[-1][:-1])
    values = [np.array([at.of_s @ piece[:-1] for piece in r]) for at in (young, old)]
    kernels = [(c * value[1:] + d * value[:-1]) ** 2 for value in values]
    matrices = [young.matrix(kernels[0][0])]
    matrices += [young.matrix(new) + old.matrix(last) for last, new in zip(kernels[1], kernels[0][1:], strict=False)]
    drawn = [(c * now + d * before + s)[:-1] ** 2 for before, now in pairwise(m)]
    return Pieces(np.array(r), np.array(m), _solve_renewal([matrix[:-1] for matrix in matrices], drawn))


def _solve_renewal(matrices: list[Array], drawn: list[Array]) -> Array:
    """Solve gamma_k = drawn_k + sum_j M_{k-j} gamma_j, piece by piece."""
    n, count = len(drawn[0]), len(drawn)
    inverse, oldest_first = np.linalg.inv(np.eye(n) - matrices[0]), np.hstack(matrices[:0:-1] or [np.zeros((n, 0))])
    gamma = np.zeros((count, n))
    for k, given in enumerate(drawn):
        gamma[k] = inverse @ (given + oldest_first[:, n * (count - 1 - k) :] @ gamma[:k].ravel())
    return gamma


@cache
def _ends(equation: ScalarDelay) -> Array:
    A, B, c, d, *_ = equation
    growth = max(A, 0.0) + max(abs(B) - abs(A), 0.0) + max(c * c + 2.0 * A, 0.0) + max(d * d + 2.0 * A, 0.0)
    fastest = abs(A) + abs(B) + c * c + d * d
    # Negated so that NaN is rejected, too.
    if not growth * equation.tau <= MOST_GROWTH or not fastest < np.inf:
        text = f"must be finite and grow by no more than e^{MOST_GROWTH:g} within a delay, got {equation[:4]}"
        raise ParameterError(f"a delay equation with A, B, c, d {text}")
    return grade_panels(equation.tau, fastest, growth)


@cache
def _convolutions(equation: ScalarDelay, times: tuple[float, ...]) -> tuple[Convolution, Convolution]:
    ends, u = _ends(equation), np.array(times)
    return convolution(ends, u), convolution(ends, u, older=True)
