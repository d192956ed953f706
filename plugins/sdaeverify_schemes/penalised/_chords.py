"""Newton's method for a position, with a new matrix in some iterations only."""

from collections.abc import Callable, Container
from typing import NamedTuple, Protocol

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.numerics import norm

# Tolerance of the error relative to |x|, a few times its rounding errors. The error is estimated by the last update
# times the last contraction.
LEFT = 2e-15


class Local(Protocol):
    """A system at one iterate, whose matrix is computed on demand."""

    @property
    def defect(self) -> Array:
        """Return the residual."""

    def update(self, defect: Array) -> Array:
        """Return the decrement of Newton's method for a residual, shape (d, P)."""

    def positive(self) -> Mask:
        """Return on which paths the determinant of Newton's matrix is positive."""


class Ending(NamedTuple):
    """Result of the iteration.

    Attributes
    ----------
    x : ndarray, shape (d, P)
    converged : ndarray of bool, shape (P,)
        Whether the remaining error is rounding.
    updates, matrices : ndarray of int, shape (P,)
        Number of iterations, and of those with a new matrix.
    first, second : ndarray, shape (P,)
        Lengths of the first two updates; the second may use the matrix of the first.
    last : Local
        System of the last matrix.
    """

    x: Array
    converged: Mask
    updates: Array
    matrices: Array
    first: Array
    second: Array
    last: Local


def iterate(local: Callable[[Array], Local], x: Array, anew: Container[int], most: int) -> Ending:
    """Iterate from x on every path.

    With a matrix computed at an error e, k iterations leave an error of about e^(k + 1). Therefore a matrix that
    costs more than an evaluation of the residual should be used more than once, Shamanskii (1967).

    Parameters
    ----------
    local : callable, ndarray of shape (d, P) -> Local
    x : ndarray, shape (d, P)
    anew : container of int
        Numbers of the iterations, from 0 on, that compute a new matrix in addition to the first one.
    most : int
        Largest number of iterations.
    """
    size = norm(x)
    enough = LEFT * np.where(size > 0.0, size, 1.0)
    active, updates = np.ones(len(size), dtype=bool), np.zeros(len(size), dtype=np.int64)
    matrices = updates + 1
    last = local(x)
    update = last.update(last.defect)
    first = second = before = length = norm(update)
    for n in range(1, most + 1):
        x = np.where(active, x - update, x)
        updates += active
        # Written so that NaN stays active and counts as a failure.
        active &= ~(length * np.minimum(length, before) <= enough * before)
        if n == most or not active.any():
            break
        new, before = local(x), length
        if n in anew:
            last, matrices = new, matrices + active
        update = last.update(new.defect)
        length = norm(update)
        second = length if n == 1 else second
    return Ending(x, ~active, updates, matrices, first, second, last)
