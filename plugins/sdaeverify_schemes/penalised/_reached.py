"""Result of an iteration for a multiplier, and whether it is the admissible root."""

from typing import NamedTuple

from sdaeverify import Array, Mask
from sdaeverify.numerics import norm

from ._chords import Ending

# By Kantorovich's theorem the root that Newton's method reaches from 0 is at most twice as far as the first update.
# For a quadratic constraint with q = 1, this distinguishes the near root from the far one.
NEAR, ROUNDING = 2.0, 1e-9


class Reached(NamedTuple):
    """Result of a step.

    Attributes
    ----------
    x : ndarray, shape (d, P)
    found : ndarray of bool, shape (P,)
        Whether the root is continuously connected to lambda = 0, by these criteria: the iteration converged, Newton's
        matrix has det > 0, and the root is at most twice as far as the first update.
    updates, matrices : ndarray of int, shape (P,)
        Number of iterations, and of those with a new matrix.
    """

    x: Array
    found: Mask
    updates: Array
    matrices: Array

    @classmethod
    def by(cls, end: Ending, y: Array) -> "Reached":
        """Judge the result of an iteration from y."""
        near = norm(end.x - y) <= NEAR * end.first + ROUNDING * norm(y)
        return cls(end.x, end.converged & near & end.last.positive(), end.updates, end.matrices)

    def merge(self, where: Mask, again: "Reached") -> "Reached":
        """Replace the results on some paths by those of a further search, and add its iterations."""
        x, found, updates, matrices = (part.copy() for part in self)
        x[:, where], found[where] = again.x, again.found
        updates[where] += again.updates
        matrices[where] += again.matrices
        return Reached(x, found, updates, matrices)
