"""The linearised constraint at a position of every path, as an object with the operations that schemes need."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from ...arrays import Array, Mask
from ...errors import ProblemError
from ...numerics.linalg import (
    Dense,
    apply,
    apply_transposed,
    norm,
    product_transposed,
)
from ..checks import PROBES, check_shape, wave


class Gram(Protocol):
    """A matrix Dg(x) M^{-1} grad g(y), shape (m, m) on every path."""

    def solve(self, b: Array) -> Array:
        """Solve A c = b for b of shape (m, P) or (m, k, P)."""

    def positive(self) -> Mask:
        """Return the paths on which det A > 0, shape (P,)."""


class ConstraintJacobian(Protocol):
    """Dg(r), of m constraints and n positions."""

    def times(self, y: Array) -> Array:
        """Return Dg y, shape (n, P) or (n, k, P) -> (m, P) or (m, k, P)."""

    def transposed(self, c: Array) -> Array:
        """Return grad g c, shape (m, P) or (m, k, P) -> (n, P) or (n, k, P)."""

    def gram(self, other: Any) -> Gram:
        """Return Dg(r) M^{-1} grad g(r_0), where `other` is the linearisation at r_0; G_M if r_0 = r."""

    def size(self) -> Array:
        """Return the Frobenius norm of Dg, shape (P,)."""


class DenseJacobian(NamedTuple):
    """A Jacobian without structure.

    Attributes
    ----------
    Dg : ndarray, shape (m, n, P)
    inverse_mass : ndarray, shape (n, n), or None
        M^{-1}; None for the identity.
    """

    Dg: Array
    inverse_mass: Array | None = None

    def times(self, y: Array) -> Array:
        """Return Dg y."""
        return apply(self.Dg, y)

    def transposed(self, c: Array) -> Array:
        """Return grad g c."""
        return apply_transposed(self.Dg, c)

    def gram(self, other: "DenseJacobian") -> Dense:
        """Return Dg M^{-1} grad g, where grad g belongs to the position of `other`."""
        if self.inverse_mass is None:
            return Dense(product_transposed(self.Dg, other.Dg))
        return Dense(product_transposed(self.Dg, np.einsum("ij,mjp->mip", self.inverse_mass, other.Dg)))

    def size(self) -> Array:
        """Return the Frobenius norm of Dg."""
        return norm(self.Dg.reshape(-1, self.Dg.shape[-1]))


def check_linearisation(given: ConstraintJacobian, dense: ConstraintJacobian, n: int, m: int) -> None:
    """Check that an author's linearised constraint agrees with the derivative of the constraint.

    Parameters
    ----------
    given : ConstraintJacobian
        At `PROBES` positions.
    dense : ConstraintJacobian
        The dense matrix at the same positions.
    n, m : int
        Numbers of positions and of constraints.

    Raises
    ------
    ProblemError
        If one of its operations returns another shape or other numbers.
    """
    y, c = wave((n, PROBES)), wave((m, PROBES))
    pairs = {
        "times": (given.times(y), dense.times(y)),
        "transposed": (given.transposed(c), dense.transposed(c)),
        "gram": (given.gram(given).solve(c), dense.gram(dense).solve(c)),
        "size": (given.size(), dense.size()),
    }
    for name, (value, expected) in pairs.items():
        check_shape(f"linearisation(r).{name}", value, expected.shape)
        if not np.allclose(value, expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max()):
            raise ProblemError(f"linearisation(r).{name} disagrees with the derivative of constraint")
