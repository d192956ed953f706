"""Projection onto a manifold g = 0."""

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array
from ..numerics.derivatives import jacobian
from .mechanics.jacobian import ConstraintJacobian, DenseJacobian
from .problem import Problem

STEPS = 50


class LevelSets(Problem):
    """A problem with ``constraint`` = 0 for the first ``dimension`` components, and its Jacobian ``dg``."""

    absent: ClassVar[str] = "has no constraint on its positions"

    constraint: Callable[[Array], Array]
    jacobian: Callable[[Array], Array] | None

    def dg(self, x: Array) -> Array:
        """Return Dg(x), shape (m, n, P)."""
        return self.jacobian(x) if self.jacobian is not None else jacobian(self.constraint, x)

    def linearised(self, x: Array) -> ConstraintJacobian:
        """Return Dg(x) as an object with the operations that schemes need."""
        return DenseJacobian(self.dg(x))

    def push(self, J: ConstraintJacobian, c: Array) -> Array:
        """Return the change of a state by multipliers c of shape (m, P): grad g c, shape (n, P)."""
        return J.transposed(c)


def onto_manifold(g: Callable[[Array], Array], problem: Any, x: Array) -> Array:
    """Solve g(y) = 0 by Gauss-Newton steps y <- y - M^{-1} grad g(y) G_M(y)^{-1} g(y) from y = x.

    Parameters
    ----------
    g : callable, ndarray of shape (n, P) -> ndarray of shape (m, P)
    problem : Problem
        With ``linearised`` and ``push``: Dg, and M^{-1} grad g c.
    x : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (n, P)
        Not finite on paths where the iteration breaks down.
    """
    y = x
    for _ in range(STEPS):
        value = g(y)
        if np.abs(value).max() <= 4.0 * np.finfo(float).eps:
            break
        J = problem.linearised(y)
        y = y - problem.push(J, J.gram(J).solve(value))
    return y
