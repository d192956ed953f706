"""Constraints of second degree, zeta_k(x) = x^T H_k x/2 + l_k^T x + c_k."""

from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array


class Quadrics(NamedTuple):
    """Coefficients of the constraints.

    Attributes
    ----------
    H : ndarray, shape (q, d, d)
        Symmetric.
    l : ndarray, shape (q, d)
    c : ndarray, shape (q,)
    """

    H: Array
    l: Array
    c: Array

    def zeta(self, x: Array) -> Array:
        """Return the constraints, shape (q, P)."""
        bent = 0.5 * (np.tensordot(self.H, x, 1) * x).sum(axis=1)
        return np.asarray(bent + self.l @ x + self.c[:, None])

    def jacobian(self, x: Array) -> Array:
        """Return the gradients H_k x + l_k, shape (q, d, P)."""
        return np.asarray(np.tensordot(self.H, x, 1) + self.l[..., None])

    def fields(self) -> dict[str, Any]:
        """Return the constraint, Jacobian and Hessians as fields of `ConstrainedLangevin`."""
        return {"constraint": self.zeta, "jacobian": self.jacobian, "hessians": self.H}
