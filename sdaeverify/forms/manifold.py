"""Points of a manifold g = 0 near given points."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ..arrays import Array
from .mechanics.jacobian import ConstraintJacobian
from .problem import Problem

STEPS = 50


class LevelSets(Problem):
    """A problem with ``constraint`` = 0 for the first ``dimension`` components, and its Jacobian ``dg``."""

    absent: ClassVar[str] = "has no constraint on its positions"


def onto_manifold(
    g: Callable[[Array], Array],
    linearised: Callable[[Array], ConstraintJacobian],
    push: Callable[[ConstraintJacobian, Array], Array],
    x: Array,
) -> Array:
    """Solve g(y) = 0 by Gauss-Newton steps y <- y - M^{-1} grad g(y) G_M(y)^{-1} g(y) from y = x.

    Parameters
    ----------
    g : callable, ndarray of shape (n, P) -> ndarray of shape (m, P)
    linearised : callable, ndarray of shape (n, P) -> ConstraintJacobian
        Dg.
    push : callable, (ConstraintJacobian, ndarray of shape (m, P)) -> ndarray of shape (n, P)
        M^{-1} grad g c.
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
        J = linearised(y)
        y = y - push(J, J.gram(J).solve(value))
    return y
