"""The invariant law of constrained Langevin dynamics on the unit sphere, by quadrature.

Positions have the density exp(-V/kT) with respect to the surface measure of the metric of M, which is, up to a
constant, sqrt(x^T M^{-1} x) times the ordinary one; velocities at x are normal with mean 0 and covariance

    C(x) = kT ( M^{-1} - M^{-1} x x^T M^{-1} / (x^T M^{-1} x) ),      tr(M C) = (n - 1) kT.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, InvariantMean, ParameterError

from .._known import limits

SOURCE = "density exp(-V/kT) sqrt(x^T M^-1 x) on the sphere, normal velocities; quadrature converged to rounding"
FEWEST, MOST = 32, 1024
# Both rules converge geometrically for these densities: if a doubling changes a mean by d, the next one changes it by
# about d^2. With this d only rounding remains, and d is far above the rounding error of half a million terms.
CHANGE = 1e-11

Nodes = Callable[[int], tuple[Array, Array]]


class Canonical(NamedTuple):
    """Potential, masses and temperature that determine the law.

    Attributes
    ----------
    potential : callable, x -> ndarray, shape (P,)
        Potential V.
    mass : ndarray, shape (n, n)
        Mass matrix M.
    kT : float
    """

    potential: Callable[[Array], Array]
    mass: Array
    kT: float

    def means(self, nodes: Nodes, count: int) -> dict[str, float]:
        """Return the means of r_i, r_i^2, v_i, |v|^2, |v|^4 and v^T M v by quadrature."""
        x, surface = nodes(count)
        inverse, energy = np.linalg.inv(self.mass), self.potential(x) / self.kT
        pushed = inverse @ x
        square = (x * pushed).sum(axis=0)
        weights = surface * np.sqrt(square) * np.exp(energy.min() - energy)
        weights = weights / weights.sum()
        C = self.kT * (inverse[..., None] - pushed[:, None] * pushed[None] / square)
        speed = np.einsum("iip->p", C)
        values = {f"r_{i + 1}": row for i, row in enumerate(x)} | {f"r_{i + 1}^2": row**2 for i, row in enumerate(x)}
        values |= {"|v|^2": speed, "|v|^4": speed**2 + 2.0 * (C * C).sum(axis=(0, 1))}
        exact = {f"v_{i + 1}": 0.0 for i in range(len(x))} | {"v^T M v": (len(x) - 1) * self.kT}
        return {name: float(weights @ value) for name, value in values.items()} | exact


def invariant_means(law: Canonical, nodes: Nodes, names: Iterable[str]) -> tuple[InvariantMean, ...]:
    """Return the invariant means of observables, doubling the nodes until only rounding errors remain.

    Parameters
    ----------
    law : Canonical
    nodes : callable, count -> ndarray of shape (n, P) and ndarray of shape (P,)
        Points of the sphere and their weights for its Euclidean surface measure, up to a constant.
    names : iterable of str
        Observables of the problem; those with a mean that is not computed are skipped.

    Returns
    -------
    tuple of InvariantMean

    Raises
    ------
    ParameterError
        If the law is too narrow for the finest quadrature.
    """
    count, coarse = FEWEST, law.means(nodes, FEWEST)
    while count < MOST:
        count *= 2
        fine = law.means(nodes, count)
        if all(abs(fine[name] - coarse[name]) <= CHANGE * (1.0 + abs(fine[name])) for name in fine):
            return limits({name: fine[name] for name in names if name in fine}, SOURCE)
        coarse = fine
    raise ParameterError(
        f"the invariant law is too narrow for {MOST} nodes with kT = {law.kT!r}, these masses and this force"
    )


def circle_nodes(count: int) -> tuple[Array, Array]:
    """Return points of the circle, by the midpoint rule in the angle, and their weights.

    The highest and lowest point are never nodes, so that a law which is too narrow at them does not look resolved.
    """
    theta = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    return np.stack([np.sin(theta), -np.cos(theta)]), np.ones(count)


def sphere_nodes(count: int) -> tuple[Array, Array]:
    """Return points of the sphere in R^3, by Gauss' rule in x_3 and the midpoint rule in the longitude."""
    height, weights = np.polynomial.legendre.leggauss(count // 2)
    radius, (east, north) = np.sqrt(1.0 - height**2), circle_nodes(count)[0]
    x = np.stack([np.outer(radius, east), np.outer(radius, north), np.outer(height, np.ones(count))])
    return x.reshape(3, -1), np.repeat(weights, count)
