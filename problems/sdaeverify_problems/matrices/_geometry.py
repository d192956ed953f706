"""Matrices near x^T x = Id: the geometry of the constraint in closed form.

With C = x^T x, symmetric with eigenvalues c_i, and g lambda = x Lambda for symmetric Lambda:

    g G^{-1} zeta = x (Id - C^{-1})/2,    g'(w) c = x (Id - C^{-1})^2/4,    grad ln det G = 2 x Psi,

Psi with the eigenvectors of C and the eigenvalues psi_i = 1/c_i + sum_{j != i} 1/(c_i + c_j).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, ConstraintGeometry
from sdaeverify.numerics import Root, eliminated

from ._constraint import MatrixJacobian
from ._inverse_sums import inverse_sums
from ._lyapunov import product, transposed_product
from ._root import MatrixLevel
from ._upper import Upper


@dataclass(frozen=True, eq=False)
class MatrixGeometry(ConstraintGeometry):
    """Closed forms at x, stored by rows of p components, of shape (d p, P)."""

    p: int = 1

    @classmethod
    def near(cls, p: int, problem: ConstrainedLangevin, x: Array) -> "MatrixGeometry":
        """Return the geometry at x."""
        return cls(problem, x, p)

    @cached_property
    def rows(self) -> Array:
        """Return x as a matrix, shape (d, p, P)."""
        return self.x.reshape(-1, self.p, self.x.shape[-1])

    @cached_property
    def C(self) -> Array:
        """Return C = x^T x, shape (p, p, P)."""
        return transposed_product(self.rows, self.rows)

    @cached_property
    def J(self) -> MatrixJacobian:
        """Return the Jacobian y -> x^T y + y^T x."""
        return MatrixJacobian(self.rows)

    @cached_property
    def zeta(self) -> Array:
        """Return the entries of C - Id on and above the diagonal, shape (q, P)."""
        return self._upper(self.C - self._identity)

    @cached_property
    def excess(self) -> Array:
        """Return W = Id - C^{-1} = C^{-1} (C - Id), shape (p, p, P)."""
        return eliminated(self.C).solve(self.C - self._identity)

    @cached_property
    def psi(self) -> Array:
        """Return Psi, shape (p, p, P)."""
        return inverse_sums(self.C) + 0.5 * (self._identity - self.excess)

    @cached_property
    def share(self) -> Array:
        """Return c = G^{-1} zeta, shape (q, P): x W/2 = x Lambda with Lambda_ij = c_ij, Lambda_ii = 2 c_ii."""
        halves = np.where(Upper.of(self.p).diagonal, 0.25, 0.5)[:, None]
        return np.asarray(halves * self._upper(self.excess))

    @cached_property
    def relaxation(self) -> Array:
        """Return w = x W/2, shape (d p, P)."""
        return self._times(0.5 * self.excess)

    @cached_property
    def quadratic(self) -> Array:
        """Return g'(w) c = x W^2/4, shape (d p, P)."""
        return self._times(0.25 * product(self.excess, self.excess))

    @cached_property
    def fixman(self) -> Array:
        """Return grad ln det G = 2 x Psi, shape (d p, P)."""
        return self._times(2.0 * self.psi)

    @cached_property
    def divergence(self) -> Array:
        """Return (tr H_k)_k, the entries of 2 d Id, shape (q, P)."""
        return 2.0 * len(self.rows) * Upper.of(self.p).diagonal[:, None] + 0.0 * self.x[:1]

    @cached_property
    def normal_traces(self) -> Array:
        """Return (tr H_k P)_k, the entries of 2 ((p + 1) Id - C Psi), shape (q, P)."""
        return self._upper(2.0 * ((self.p + 1.0) * self._identity - product(self.C, self.psi)))

    def root(self, y: Array, level: Array) -> Root:
        """Return y + x Lambda, shape (d p, P), with the entries of `level` in x^T x - Id."""
        target = self._identity + level[Upper.of(self.p).number]
        root = MatrixLevel.of(self.rows, self.C, y.reshape(self.rows.shape), target).solve()
        return root._replace(x=y + self._times(root.x.reshape(self.C.shape)))

    @property
    def _identity(self) -> Array:
        return np.eye(self.p)[..., None]

    def _upper(self, A: Array) -> Array:
        upper = Upper.of(self.p)
        return np.asarray(A[upper.i, upper.j])

    def _times(self, A: Array) -> Array:
        return product(self.rows, A).reshape(self.x.shape)
