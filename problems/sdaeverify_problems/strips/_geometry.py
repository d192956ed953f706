"""The constraint zeta(t, n) = e^{alpha t} n and its derivatives in closed form; D = 1 + alpha^2 |n|^2 throughout."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, ConstraintGeometry


@dataclass(frozen=True)
class StripConstraint:
    """The constraint as functions of x = (t, n), shape (1 + q, P).

    Attributes
    ----------
    alpha : float
    """

    alpha: float

    def zeta(self, x: Array) -> Array:
        """Return zeta, shape (q, P)."""
        return np.asarray(np.exp(self.alpha * x[0]) * x[1:])

    def jacobian(self, x: Array) -> Array:
        """Return g^T = e^{alpha t} (alpha n, Id), shape (q, 1 + q, P)."""
        units = np.eye(len(x) - 1)[..., None] + 0.0 * x[0]
        return np.asarray(np.exp(self.alpha * x[0]) * np.concatenate([self.alpha * x[1:, None], units], axis=1))

    def second(self, x: Array, A: Array) -> Array:
        """Return sum_k H_k A_k: H_k has alpha^2 e^{alpha t} n_k at (t, t) and alpha e^{alpha t} at (t, n_k)."""
        n, growth = x[1:], self.alpha * np.exp(self.alpha * x[0])
        along = self.alpha * (n * A[0]).sum(axis=0) + np.einsum("kkp->p", A[1:])
        return np.asarray(growth * np.concatenate([along[None], A[0]]))

    def laplacians(self, x: Array) -> Array:
        """Return tr H_k = alpha^2 e^{alpha t} n_k, shape (q, P)."""
        return self.alpha**2 * self.zeta(x)

    def geometry(self, problem: ConstrainedLangevin, x: Array) -> "StripGeometry":
        """Return the closed forms at x."""
        return StripGeometry(problem, x, self.alpha)


@dataclass(frozen=True, eq=False)
class StripGeometry(ConstraintGeometry):
    """g G^{-1} zeta = (alpha |n|^2, n)/D and ln det G = 2 q alpha t + ln D, with what follows from them."""

    alpha: float = 1.0

    @cached_property
    def _square(self) -> Array:
        return np.asarray((self.x[1:] ** 2).sum(axis=0))

    @cached_property
    def _D(self) -> Array:
        return np.asarray(1.0 + self.alpha**2 * self._square)

    @cached_property
    def share(self) -> Array:
        """Return c = G^{-1} zeta = e^{-alpha t} n/D, shape (q, P)."""
        return np.asarray(np.exp(-self.alpha * self.x[0]) * self.x[1:] / self._D)

    @cached_property
    def relaxation(self) -> Array:
        """Return w = (alpha |n|^2, n)/D, shape (1 + q, P)."""
        return np.asarray(np.concatenate([self.alpha * self._square[None], self.x[1:]]) / self._D)

    @cached_property
    def quadratic(self) -> Array:
        """Return g'(w) c = (alpha |n|^2 D, alpha^2 |n|^2 n)/D^2, shape (1 + q, P)."""
        return (
            self.alpha
            * self._square
            / self._D
            * np.concatenate([0.0 * self.x[:1] + 1.0, self.alpha * self.x[1:] / self._D])
        )

    @cached_property
    def fixman(self) -> Array:
        """Return grad ln det G = (2 q alpha, 2 alpha^2 n/D), shape (1 + q, P)."""
        n = self.x[1:]
        along = 2.0 * len(n) * self.alpha + 0.0 * self.x[:1]
        return np.concatenate([along, 2.0 * self.alpha**2 * n / self._D])
