"""Newton's method for small systems on every path at once: failure is a value, not an exception."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, Mask
from .linalg import largest, solve

Linearisation = Callable[[Array], tuple[Array, Any]]
Solver = Callable[[Any, Array], Array]


# Newton's last update is below this part of the solution, so that its error is rounding: about the square.
RELATIVE = 1e-9
# Where F has fallen to this part of what it was, the derivative before may do for the last update.
FALLEN = 1e-6


class Root(NamedTuple):
    """What Newton's method reached.

    Attributes
    ----------
    x : ndarray, shape (m, P)
        Last iterate of each path.
    converged : ndarray of bool, shape (P,)
        Whether the last update of the path was below its tolerance.
    iterations : ndarray of int, shape (P,)
        Updates made on the path.
    """

    x: Array
    converged: Mask
    iterations: Array


def newton(
    f: Linearisation,
    x: Array,
    tolerance: float | Array,
    max_iterations: int = 30,
    solver: Solver = solve,
    size: Callable[[Array], Array] = largest,
) -> Root:
    """Solve F(x) = 0 from a starting point on every path.

    A path stops when an update is of at most `tolerance` in size, and stays as it is while
    the others go on, so that no path depends on its neighbours. The accepted iterate includes that last
    update: Newton converges quadratically, its error is then far below the tolerance.

    The last update needs no derivative of its own where that before gives the same: an update u after one of u_0
    tells that DF has changed by about the part |u|/|u_0| of itself, so that u is off by |u|^2/|u_0|, which is to be
    rounding. Where F is affine that is so from the second update on.

    Parameters
    ----------
    f : callable
        Gives F(x), shape (m, P), and DF(x): shape (m, m, P), or what `solver` takes in its place; or a function of
        nothing that gives it, which is asked only where it is needed.
    x : ndarray, shape (m, P)
        Starting point.
    tolerance : float or ndarray, shape (P,)
        Size of the largest accepted update.
    max_iterations : int, optional
    solver : callable, (DF(x), F(x)) -> ndarray, shape (m, P), optional
        Solves the linear systems.
    size : callable, ndarray of shape (m, P) -> ndarray of shape (P,), optional
        Size of an update; its largest component if left out.

    Returns
    -------
    Root
    """
    left = paths = x.shape[1]
    iterations, active = np.zeros(paths, dtype=np.int64), np.ones(paths, dtype=bool)
    made: _Made | None = None
    for _ in range(max_iterations):
        value, matrix = f(x)
        again = None if made is None else made.once_more(value, active, tolerance)
        if again is not None and again.done.all():
            update, length = again.update, again.length
        else:
            fresh = matrix() if callable(matrix) else matrix
            update = solver(fresh, value) if again is None else again.completed(active, solver(fresh, value))
            length = size(update)
            made = _Made(fresh, FALLEN * largest(value), length, solver, size) if callable(matrix) else None
        # Most often all paths stop together: what masks cost is then saved.
        together = left == paths
        x = x - update if together else np.where(active, x - update, x)
        iterations += 1 if together else active
        # Written so that a NaN stays active and ends as a failure.
        active &= ~(length <= tolerance)
        left = np.count_nonzero(active)
        if not left:
            break
    return Root(x, ~active, iterations)


class _Again(NamedTuple):
    """An update by the matrix of the one before, its size, and the paths that need no other or none at all."""

    update: Array
    length: Array
    done: Mask

    def completed(self, active: Mask, fresh: Array) -> Array:
        """Return it where it is enough, and a fresh update elsewhere."""
        return np.where(active & self.done, self.update, fresh)


class _Made(NamedTuple):
    """An update that was made: by a matrix, so long; `small` is where F is so much smaller than it was there."""

    matrix: Any
    small: Array
    length: Array
    solver: Solver
    size: Callable[[Array], Array]

    def once_more(self, value: Array, active: Mask, tolerance: float | Array) -> _Again | None:
        """Return the update of another value by the same matrix, or None where no path has come near enough."""
        fallen = active & (largest(value) <= self.small)
        if not np.count_nonzero(fallen):
            return None
        update = self.solver(self.matrix, value)
        length = self.size(update)
        sure = (length <= tolerance) & (length**2 <= RELATIVE * tolerance * self.length)
        return _Again(update, length, ~active | (fallen & sure))


def update_tolerance(*sizes: Array) -> Array:
    """Return the size of an update that leaves rounding alone, for solutions as large as the largest of these.

    Parameters
    ----------
    *sizes : ndarray, shape (P,)
        Not negative; where all are 0, the tolerance is that of a solution of size 1.

    Returns
    -------
    ndarray, shape (P,)
    """
    size = sizes[0] if len(sizes) == 1 else np.fmax.reduce(sizes)
    # As a rule none is 0: to look costs a third of `numpy.where`.
    return np.asarray(RELATIVE * (size if size.all() else np.where(size > 0.0, size, 1.0)))
