"""Newton's method for a position, its matrix made anew in some iterations only."""

from collections.abc import Callable, Container
from typing import NamedTuple, Protocol

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.numerics import norm

# What is left of the error, estimated by the last update times the last contraction, in parts of |x|: a few times
# its rounding errors.
LEFT = 2e-15


class Local(Protocol):
    """A system at one iterate; its matrix is made when it is asked for."""

    @property
    def defect(self) -> Array:
        """Return what has to vanish."""

    def update(self, defect: Array) -> Array:
        """Return what Newton's method takes away from an iterate with this defect, shape (d, P)."""

    def positive(self) -> Mask:
        """Tell on which paths the determinant of Newton's matrix is positive."""


class Ending(NamedTuple):
    """Where the iteration ended.

    Attributes
    ----------
    x : ndarray, shape (d, P)
    converged : ndarray of bool, shape (P,)
        Whether what is left of the error is rounding.
    updates, matrices : ndarray of int, shape (P,)
        Iterations, and those of them with a matrix of their own: Newton's.
    first, second : ndarray, shape (P,)
        Lengths of the first two updates, the second with the matrix of the first if it is used again.
    last : Local
        Where the last matrix was made.
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

    The first k iterations of a matrix that was made where the error was e leave about e^(k + 1): a matrix that costs
    more than an evaluation of the defect should be used more than once, Shamanskii (1967).

    Parameters
    ----------
    local : callable, ndarray of shape (d, P) -> Local
    x : ndarray, shape (d, P)
    anew : container of int
        Numbers of the iterations, from 0 on, that make a new matrix beside the first one.
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
        # Written so that a NaN stays active and ends as a failure.
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
