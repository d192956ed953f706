"""Expectations at all times of a reversible diffusion on [-1, 1] with the generator L phi = (1/rho) (rho D phi')'.

On polynomials of degree below n, L is symmetric in the inner product of rho; with its eigenvalues -l_k and normalised
eigenfunctions psi_k,

    E phi(c_t) = phi(c_0) + sum_k (e^{-l_k t} - 1) psi_k(c_0) <psi_k, phi>.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.polynomial import legendre

from sdaeverify import Array


@dataclass(frozen=True, eq=False)
class IntervalDiffusion:
    """A diffusion on an interval, with a quadrature for its invariant law.

    Attributes
    ----------
    nodes, weights : ndarray, shape (Q,)
        Quadrature for the density rho; the weights sum to 1.
    D : ndarray, shape (Q,)
        Values at the nodes of D, which is 0 at the ends of the interval.
    count : int
        Number n of polynomials, less than the number of nodes.
    """

    nodes: Array
    weights: Array
    D: Array
    count: int

    def mean(self, phi: Callable[[Array], Array]) -> float:
        """Return the mean of phi under the invariant law."""
        return float(self.weights @ phi(self.nodes))

    def expectation(self, phi: Callable[[Array], Array], start: float, t: float) -> float:
        """Return E phi(c_t) from c_0 = start."""
        values, functions = self._modes
        shares = functions.T @ (self._polynomials @ (self.weights * phi(self.nodes)))
        here = functions.T @ legendre.legvander(np.array([start]), self.count - 1)[0]
        return float(phi(np.array([start]))[0] + np.expm1(-values * t) @ (here * shares))

    @property
    def gap(self) -> float:
        """Smallest positive eigenvalue of -L, the rate at which the influence of the start decays."""
        return float(self._modes[0][1])

    @cached_property
    def _polynomials(self) -> Array:
        return np.asarray(legendre.legvander(self.nodes, self.count - 1).T)

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        basis, units = self._polynomials, np.eye(self.count)
        slopes = np.stack([legendre.legval(self.nodes, legendre.legder(unit)) for unit in units])
        values, functions = scipy.linalg.eigh(
            (slopes * self.weights * self.D) @ slopes.T, (basis * self.weights) @ basis.T
        )
        return values, functions
