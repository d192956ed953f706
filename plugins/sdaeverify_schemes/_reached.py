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
    iterations : ndarray of int, shape (P,)
    """

    x: Array
    found: Mask
    iterations: Array

    @classmethod
    def by(cls, end: Ending, y: Array) -> "Reached":
        """Judge where an iteration from y ended."""
        near = norm(end.x - y) <= NEAR * end.first + ROUNDING * norm(y)
        return cls(end.x, end.converged & near & end.last.positive(), end.iterations)
