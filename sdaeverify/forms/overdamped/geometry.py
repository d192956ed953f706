"""The level sets of a constraint zeta near points x: its gradient, its Gram matrix and how they turn.

Symbols as in Laurent (2022): zeta : R^d -> R^q, g = grad zeta (d x q), G = g^T g, H_k the Hessian of zeta_k.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...numerics import Root
from ..mechanics.jacobian import ConstraintJacobian, Gram

if TYPE_CHECKING:
    from .constrained_langevin import ConstrainedLangevin


@dataclass(frozen=True, eq=False)
class ConstraintGeometry:
    """What schemes need of a constraint at points x, each of it computed when it is first asked for.

    Authors of problems with closed forms, matrix groups for example, override `relaxation`, `quadratic`, `fixman`
    and `divergence`, and `root` if they can find multipliers.

    Attributes
    ----------
    problem : ConstrainedLangevin
    x : ndarray, shape (d, P)
    """

    problem: "ConstrainedLangevin"
    x: Array

    @cached_property
    def zeta(self) -> Array:
        """Return zeta(x), shape (q, P)."""
        return self.problem.constraint(self.x)

    @cached_property
    def J(self) -> ConstraintJacobian:
        """Return the Jacobian g^T."""
        return self.problem.linearised(self.x)

    @cached_property
    def gram(self) -> Gram:
        """Return the Gram matrix G."""
        return self.J.gram(self.J)

    @cached_property
    def share(self) -> Array:
        """Return c = G^{-1} zeta, shape (q, P)."""
        return self.gram.solve(self.zeta)

    @cached_property
    def relaxation(self) -> Array:
        """Return w = g G^{-1} zeta, shape (d, P): the way back to the manifold, to first order."""
        return self.J.transposed(self.share)

    @cached_property
    def quadratic(self) -> Array:
        """Return g'(w) c = sum_k c_k H_k w, shape (d, P): (zeta c / 2) grad ln det G in codimension one."""
        if len(self.zeta) == 1:
            return 0.5 * self.zeta * self.share * self.fixman
        return self.problem.contraction(self.x, self.relaxation[:, None] * self.share)

    @cached_property
    def fixman(self) -> Array:
        """Return grad ln det G = 2 sum_k H_k (g G^{-1})_k, shape (d, P)."""
        return 2.0 * self.problem.contraction(self.x, np.swapaxes(self.dual, 0, 1))

    @cached_property
    def divergence(self) -> Array:
        """Return div g = (tr H_k)_k, shape (q, P)."""
        return self.problem.traces(self.x)

    @cached_property
    def dual(self) -> Array:
        """Return G^{-1} g^T, shape (q, d, P)."""
        return self.gram.solve(np.broadcast_to(self.problem.dg(self.x), (len(self.zeta), *self.x.shape)))

    @cached_property
    def normal_traces(self) -> Array:
        """Return (tr H_k P)_k with P = g G^{-1} g^T, shape (q, P): the sum over j of (g G^{-1})_j . H_k g_j."""
        gradients = np.broadcast_to(self.problem.dg(self.x), self.dual.shape)
        terms = (
            np.einsum("kdp,dp->kp", self.problem.turned(self.x, g_j), dual_j)
            for g_j, dual_j in zip(gradients, self.dual, strict=True)
        )
        return np.asarray(sum(terms, np.zeros_like(self.zeta)))

    def root(self, y: Array, level: Array) -> Root | None:  # noqa: ARG002 - most authors know no better way
        """Return x' = y + g lambda with zeta(x') = level, where the author has a way of his own; otherwise None.

        Parameters
        ----------
        y : ndarray, shape (d, P)
        level : ndarray, shape (q, P)

        Returns
        -------
        Root or None
            Converged only where it is surely the root that is connected to lambda = 0; schemes search for others.
        """
        return None

    def normal(self, y: Array) -> Array:
        """Return P y = g G^{-1} g^T y, shape (d, P)."""
        return self.J.transposed(self.gram.solve(self.J.times(y)))
