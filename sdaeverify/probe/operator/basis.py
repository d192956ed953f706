"""Orthonormal functions of one or two coordinates, and quadrature to project other functions onto them.

For an angle they are 1, sqrt(2) cos k y, sqrt(2) sin k y, orthonormal for the uniform law. For a coordinate on the
line they are h_n((y - centre)/scale) with h_n = He_n/sqrt(n!), orthonormal for the normal law of that centre and
scale. Products are used for two coordinates. The quadrature has more nodes than functions: with equal numbers,
projection would be interpolation, in which components beyond the basis are aliased onto it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms.chart import Angle, Chart, Line
from ..step.nodes import gauss_hermite

# Quadrature nodes per function of a coordinate.
# Size: nodes of a function.
OVERSAMPLING = 1.5


class AxisBasis(NamedTuple):
    """Orthonormal functions phi_0 = 1, ..., phi_{n-1} of one coordinate.

    Attributes
    ----------
    values : callable, ndarray of shape (...) -> ndarray of shape (n, ...)
    derivative : ndarray, shape (n, n)
        phi_j' = sum_i derivative[i, j] phi_i.
    nodes, weights : ndarray, shape (Q,)
        Nodes and weights of the quadrature; the weights have sum 1.
    """

    values: Callable[[Array], Array]
    derivative: Array
    nodes: Array
    weights: Array

    @property
    def projection(self) -> Array:
        """Matrix of shape (n, Q) that maps values at the nodes to coefficients."""
        return np.asarray(self.values(self.nodes) * self.weights)


@dataclass(frozen=True, eq=False)
class Basis:
    """Products phi_a(z_1) psi_b(z_2), ordered by (a, b) with b fastest; the first one is 1.

    Attributes
    ----------
    axes : tuple of two AxisBasis
        For a chart of one coordinate the second basis consists of the constant 1.
    dimension : int
        Number of coordinates.
    """

    axes: tuple[AxisBasis, AxisBasis]
    dimension: int

    @property
    def nodes(self) -> Array:
        """Nodes of the product quadrature, shape (dimension, Q)."""
        grid = np.meshgrid(*(axis.nodes for axis in self.axes), indexing="ij")
        return np.stack([part.ravel() for part in grid[: self.dimension]])

    @property
    def weights(self) -> Array:
        """Weights of the quadrature, of sum 1, shape (Q,)."""
        return np.outer(*(axis.weights for axis in self.axes)).ravel()

    def factors(self, z: Array | Sequence[Array]) -> tuple[Array, Array]:
        """Return the functions of the first and of the last coordinate, each at its points."""
        first, second = self.axes
        return first.values(z[0]), second.values(z[-1])

    def values(self, z: Array) -> Array:
        """Return all functions at z of shape (dimension, P), as an array of shape (n, P)."""
        first, second = self.factors(z)
        return np.asarray(np.einsum("ap,bp->abp", first, second).reshape(-1, z.shape[1]))

    def project(self, values: Array) -> Array:
        """Return the coefficients of functions from values at the nodes: shape (Q, ...) -> (n, ...)."""
        first, second = (axis.projection for axis in self.axes)
        grid = values.reshape(first.shape[1], second.shape[1], -1)
        half = np.tensordot(first, grid, axes=(1, 0))
        return np.asarray(np.matmul(second, half).reshape(-1, *values.shape[1:]))


@lru_cache(maxsize=8)
def chart_basis(chart: Chart, angle: int = 25, line: int = 24) -> Basis:
    """Return the basis for the functions of a chart.

    Parameters
    ----------
    chart : Chart
        Of one or two coordinates.
    angle, line : int
        Number of functions of an angle, odd, and of a coordinate on the line.

    Returns
    -------
    Basis
    """
    axes = [fourier(angle) if isinstance(axis, Angle) else hermite(line, axis) for axis in chart.axes]
    first, second = [*axes, _constant()][:2]
    return Basis((first, second), len(axes))


def fourier(count: int) -> AxisBasis:
    """Return the first `count` of the functions 1, sqrt(2) cos y, sqrt(2) sin y, ...; `count` is odd."""
    derivative = np.zeros((count, count))
    for k in range(1, count // 2 + 1):
        derivative[2 * k, 2 * k - 1] = -k
        derivative[2 * k - 1, 2 * k] = k
    nodes = _oversample(count)
    angles = 2.0 * np.pi / nodes * np.arange(nodes)
    return AxisBasis(partial(_fourier_values, count), derivative, angles, np.full(nodes, 1.0 / nodes))


def hermite(count: int, axis: Line) -> AxisBasis:
    """Return the normalised Hermite polynomials of (y - centre)/scale up to degree count - 1."""
    nodes, weights = gauss_hermite(_oversample(count))
    derivative = np.diag(np.sqrt(np.arange(1.0, count)), 1) / axis.scale
    return AxisBasis(partial(_hermite_values, count, axis), derivative, axis.centre + axis.scale * nodes, weights)


def _constant() -> AxisBasis:
    return AxisBasis(lambda y: np.ones((1, *y.shape)), np.zeros((1, 1)), np.zeros(1), np.ones(1))


def _oversample(count: int) -> int:
    return int(np.ceil(OVERSAMPLING * count))


def _fourier_values(count: int, y: Array) -> Array:
    values = np.empty((count, *y.shape))
    values[0] = 1.0
    turn = np.exp(1j * y)
    power = np.full(y.shape, np.sqrt(2.0), dtype=complex)
    for k in range(1, count // 2 + 1):
        power *= turn
        values[2 * k - 1], values[2 * k] = power.real, power.imag
    return values


def _hermite_values(count: int, axis: Line, y: Array) -> Array:
    # sqrt(n + 1) h_{n+1} = x h_n - sqrt(n) h_{n-1}, written in place.
    x = (y - axis.centre) / axis.scale
    values, before = np.empty((count, *y.shape)), np.empty(y.shape)
    values[0] = 1.0
    if count > 1:
        values[1] = x
    for n in range(1, count - 1):
        following = np.multiply(x, values[n], out=values[n + 1])
        following -= np.multiply(values[n - 1], np.sqrt(n), out=before)
        following *= 1.0 / np.sqrt(n + 1)
    return values
