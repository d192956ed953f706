"""Newton's method for implicit Euler steps in GGL form, vectorised over paths; failures are flagged, not raised."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.numerics import largest

from ._equations import Equations, Unknowns
from ._line_search import Iterate, replace_paths, search_line
from ._linearised import Linearised, linearise


class Stop(NamedTuple):
    """Stopping criterion of the iteration.

    Attributes
    ----------
    tolerance : float
        Tolerance of the largest component of F.
    max_iterations : int
    """

    tolerance: float
    max_iterations: int


class Root(NamedTuple):
    """Result of Newton's method.

    Attributes
    ----------
    x : Unknowns
        Last iterate of each path.
    found : ndarray of bool, shape (P,)
    iterations, halvings : ndarray of int, shape (P,)
        Number of updates on the path, and of halvings in its line searches.
    """

    x: Unknowns
    found: Mask
    iterations: Array
    halvings: Array


def solve_equations(equations: Equations, guess: Unknowns, stop: Stop) -> Root:
    """Solve the equations from a guess.

    A path has converged if no component of F exceeds the tolerance or the rounding error of its equation. It has
    failed if no point along Newton's update decreases |F|^2, or after too many iterations. The other paths continue
    without it, so that paths are independent.

    Parameters
    ----------
    equations : Equations
    guess : Unknowns
    stop : Stop

    Returns
    -------
    Root
    """
    here = Iterate(equations, guess, equations.defects(guess))
    count = here.F.square.size
    found, x, paths = np.zeros(count, dtype=bool), guess, np.arange(count)
    iterations, halvings = np.zeros((2, count), dtype=np.int64)
    for _ in range(stop.max_iterations):
        L = linearise(here.equations, here.x)
        here, lower, halved = search_line(here, L)
        iterations[paths] += 1
        halvings[paths] += halved
        x = replace_paths(x, paths, here.x)
        found[paths] = there = _is_root(here, L, stop.tolerance)
        on = np.flatnonzero(lower & ~there)
        if not on.size:
            break
        if on.size < paths.size:
            paths, here = paths[on], here.of(on)
    return Root(x, found, iterations, halvings)


def _is_root(here: Iterate, L: Linearised, tolerance: float) -> Mask:
    small = np.ones(here.F.square.size, dtype=bool)
    for part, rounding in zip(here.F.parts, L.rounding(here.x, here.F), strict=True):
        small &= largest(part) <= np.maximum(tolerance, rounding)
        # Except in the last iterations, the residual of the constraint alone exceeds the bound on all paths.
        if not small.any():
            break
    return small
