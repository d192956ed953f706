"""Where an iteration for a multiplier led, and whether it is the root that is meant."""

from typing import NamedTuple

from sdaeverify import Array, Mask
from sdaeverify.numerics import norm

from ._chords import Ending

# By Kantorovich's theorem the root that Newton's method is led to from 0 is at most twice as far as the first
# update. For a quadratic constraint, q = 1, this tells the near root from the far one.
NEAR, ROUNDING = 2.0, 1e-9


class Reached(NamedTuple):
    """Where a step leads.

    Attributes
    ----------
    x : ndarray, shape (d, P)
    found : ndarray of bool, shape (P,)
        Whether it is the root that is continuously connected to lambda = 0, as far as the way to it can tell: the
        iteration converged, det > 0 of Newton's matrix, and it is no more than twice as far as the first update.
    updates, matrices : ndarray of int, shape (P,)
        Iterations, and those of them with a matrix of their own: Newton's.
    """

    x: Array
    found: Mask
    updates: Array
    matrices: Array

    @classmethod
    def by(cls, end: Ending, y: Array) -> "Reached":
        """Judge where an iteration from y ended."""
        near = norm(end.x - y) <= NEAR * end.first + ROUNDING * norm(y)
        return cls(end.x, end.converged & near & end.last.positive(), end.updates, end.matrices)

    def merge(self, where: Mask, again: "Reached") -> "Reached":
        """Return this with some paths led elsewhere, by a search that comes on top of the first one."""
        x, found, updates, matrices = (part.copy() for part in self)
        x[:, where], found[where] = again.x, again.found
        updates[where] += again.updates
        matrices[where] += again.matrices
        return Reached(x, found, updates, matrices)
