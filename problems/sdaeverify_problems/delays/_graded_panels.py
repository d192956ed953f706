"""Piecewise polynomials on graded panels of an interval, and their convolutions, with boundary layers resolved.

Functions with layers of width 1/a at the left end need log(a) panels that double in length. In a convolution at time
u, the panels of one factor start at 0, and those of the other factor run backwards from u. Between consecutive panel
ends of both factors the product is a polynomial, which is integrated by Gauss' rule.
"""

from functools import cache
from itertools import pairwise
from math import ceil, log2
from typing import NamedTuple

import numpy as np
import scipy
from numpy.polynomial.legendre import leggauss, legvander

from sdaeverify import Array

# Number of nodes of a panel; maximal length, in units of 1/rate, of the first panel of a layer and of all panels of
# growing functions.
NODES, LAYER, GROWTH = 20, 2.0, 6.0


def grade_panels(length: float, stiffness: float, growth: float) -> Array:
    """Return the ends of panels of [0, length], ascending.

    Parameters
    ----------
    length : float
    stiffness : float
        Largest rate in a layer at the left end.
    growth : float
        Largest rate elsewhere.

    Returns
    -------
    ndarray, shape (p + 1,)
    """
    halvings = max(0, ceil(log2(max(stiffness * length / LAYER, 1.0))))
    ends = [0.0, *(length * 0.5 ** np.arange(halvings, -1, -1))]
    parts = [np.linspace(a, b, ceil(max(growth * (b - a) / GROWTH, 1.0)) + 1)[:-1] for a, b in pairwise(ends)]
    return np.concatenate([*parts, [length]])


def nodes(ends: Array) -> Array:
    """Return Gauss' nodes of all panels, ascending, shape (N,)."""
    return np.ravel(ends[:-1, None] + 0.5 * np.diff(ends)[:, None] * (1.0 + _rule().x))


def interpolation(ends: Array, points: Array) -> "scipy.sparse.csr_array":
    """Return the matrix that maps values at the nodes to values at other points, shape (Q, N)."""
    panel = np.clip(np.searchsorted(ends, points, "right") - 1, 0, len(ends) - 2)
    x = 2.0 * (points - ends[panel]) / np.diff(ends)[panel] - 1.0
    places = NODES * panel[:, None] + np.arange(NODES)
    rows = np.arange(len(points) + 1) * NODES
    values = legvander(x, NODES - 1) @ _rule().inverse
    return scipy.sparse.csr_array(
        (values.ravel(), places.ravel(), rows), shape=(len(points), NODES * (len(ends) - 1))
    )


class Convolution(NamedTuple):
    """Quadrature of kernel(s) f(q) over q, with s + q = end, at several times.

    Attributes
    ----------
    s : ndarray, shape (Q,)
        Arguments of the kernel, of all times.
    weights : ndarray, shape (Q,)
    of_s, of_q : csr_array, shape (Q, N)
        Matrices that map values at the nodes to values at s and at q.
    owner : csr_array, shape (times, Q)
        1 if a point belongs to a time, otherwise 0.
    """

    s: Array
    weights: Array
    of_s: "scipy.sparse.csr_array"
    of_q: "scipy.sparse.csr_array"
    owner: "scipy.sparse.csr_array"

    def matrix(self, kernel: Array) -> Array:
        """Return the matrix that maps values of f at the nodes to the integrals, given the kernel at s."""
        return np.asarray((self.owner @ (scipy.sparse.diags_array(self.weights * kernel) @ self.of_q)).toarray())


def convolution(ends: Array, times: Array, older: bool = False) -> Convolution:
    """Return the convolution over q in [0, u] with s = u - q, or in [u, length] with s = length + u - q if `older`.

    Parameters
    ----------
    ends : ndarray, shape (p + 1,)
    times : ndarray, shape (times,)
        Times u in [0, length].
    older : bool, optional

    Returns
    -------
    Convolution
    """
    length = ends[-1]
    found = [_points(ends, u, length, length + u) if older else _points(ends, 0.0, u, u) for u in times]
    q, s, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    counts = np.cumsum([0, *(len(points) for points, *_ in found)])
    owner = scipy.sparse.csr_array((np.ones(len(q)), np.arange(len(q)), counts), shape=(len(times), len(q)))
    return Convolution(s, weights, interpolation(ends, s), interpolation(ends, q), owner)


def _points(ends: Array, low: float, high: float, total: float) -> tuple[Array, Array, Array]:
    """Return q, s = total - q and Gauss' weights between all panel ends of q and of s."""
    inner = np.concatenate([ends, total - ends])
    cuts = np.unique([low, *inner[(inner > low) & (inner < high)], high]) if high > low else np.zeros(1)
    half, x = 0.5 * np.diff(cuts)[:, None], _rule().x
    # s is computed from the right end of its interval, so that small values do not suffer from cancellation.
    q, s = cuts[:-1, None] + half * (1.0 + x), total - cuts[1:, None] + half * (1.0 - x)
    return q.ravel(), s.ravel(), (half * _rule().w).ravel()


class _Rule(NamedTuple):
    """Gauss' rule on [-1, 1], and the matrix that maps values at its nodes to Legendre coefficients."""

    x: Array
    w: Array
    inverse: Array


@cache
def _rule() -> _Rule:
    x, w = leggauss(NODES)
    return _Rule(x, w, np.linalg.inv(legvander(x, NODES - 1)))
