"""The constraint zeta(t, n) = e^{alpha t} n of points x = (t, n), and its derivatives."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array


class StripConstraint(NamedTuple):
    """The constraint as functions of x, shape (1 + q, P).

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
