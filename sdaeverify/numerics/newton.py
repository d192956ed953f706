"""Newton's method for small systems on every path at once; failure is reported in the result, not raised."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, Mask
from .linalg import largest, solve

Linearisation = Callable[[Array], tuple[Array, Any]]
Solver = Callable[[Any, Array], Array]


# Largest accepted last update relative to the solution; the error after it is about the square, below rounding.
RELATIVE = 1e-9
# Relative difference that is attributed to rounding and to solvers that have converged, which stop at this bound.
SOLVED = RELATIVE
# If F has fallen to this part of its value at the last factorised matrix, that matrix may be used for the last
# update.
FALLEN = 1e-6


class Root(NamedTuple):
    """Result of Newton's method.

    Attributes
    ----------
    x : ndarray, shape (m, P)
        Last iterate of each path.
    converged : ndarray of bool, shape (P,)
        Whether the last update of the path was below its tolerance.
    iterations : ndarray of int, shape (P,)
        Number of updates of the path.
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

    A path stops when the size of an update is at most `tolerance`, and is not changed while other paths go on, so
    that no path depends on its neighbours. The last update is included: Newton's method converges quadratically, so
    that the error after it is far below the tolerance.

    The last update may reuse the matrix of the previous one. If an update u by that matrix follows one of u_0, DF has
    changed by a relative amount of about |u|/|u_0|, so that u has an error of |u|^2/|u_0|, which has to be below
    rounding. If F is affine, this holds from the second update on.

    Parameters
    ----------
    f : callable
        Returns F(x), shape (m, P), and DF(x): shape (m, m, P), or another object that `solver` accepts, or a function
        without arguments that returns it, called only if needed.
    x : ndarray, shape (m, P)
        Starting point.
    tolerance : float or ndarray, shape (P,)
        Largest size of an update after which a path stops.
    max_iterations : int, optional
    solver : callable, (DF(x), F(x)) -> ndarray, shape (m, P), optional
        Solves the linear systems.
    size : callable, ndarray of shape (m, P) -> ndarray of shape (P,), optional
        Size of an update; by default its largest absolute component.

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
        # Usually all paths stop together: the cost of masks is saved then.
        together = left == paths
        x = x - update if together else np.where(active, x - update, x)
        iterations += 1 if together else active
        # Written so that a NaN stays active and is reported as a failure.
        active &= ~(length <= tolerance)
        left = np.count_nonzero(active)
        if not left:
            break
    return Root(x, ~active, iterations)


class _Again(NamedTuple):
    """An update by the previous matrix, its size, and the paths that need no update by a fresh matrix."""

    update: Array
    length: Array
    done: Mask

    def completed(self, active: Mask, fresh: Array) -> Array:
        """Return this update where it is accurate enough or not needed, and a fresh one elsewhere."""
        return np.where(active & self.done, self.update, fresh)


class _Made(NamedTuple):
    """The last update: its matrix, its size, and the size of F below which the matrix may be reused."""

    matrix: Any
    small: Array
    length: Array
    solver: Solver
    size: Callable[[Array], Array]

    def once_more(self, value: Array, active: Mask, tolerance: float | Array) -> _Again | None:
        """Return the update by the same matrix for a new value of F, or None if F is not small enough on any path."""
        fallen = active & (largest(value) <= self.small)
        if not np.count_nonzero(fallen):
            return None
        update = self.solver(self.matrix, value)
        length = self.size(update)
        sure = (length <= tolerance) & (length**2 <= RELATIVE * tolerance * self.length)
        return _Again(update, length, ~active | (fallen & sure))


def update_tolerance(*sizes: Array) -> Array:
    """Return the tolerance of updates below which only rounding remains, relative to the largest of some sizes.

    Parameters
    ----------
    *sizes : ndarray, shape (P,)
        Not negative; where all are 0, the tolerance is for a solution of size 1.

    Returns
    -------
    ndarray, shape (P,)
    """
    size = sizes[0] if len(sizes) == 1 else np.fmax.reduce(sizes)
    # Usually no size is 0: checking `all` first saves a third of the time of `numpy.where`.
    return np.asarray(RELATIVE * (size if size.all() else np.where(size > 0.0, size, 1.0)))
