"""The constraint of an index-1 problem solved for its algebraic components."""

from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...numerics import largest, newton, solve, update_tolerance

if TYPE_CHECKING:
    from .delay_sdae import DelaySDAE


def solve_algebraic(problem: "DelaySDAE", t: float, x: Array, v: Array, guess: Array) -> Array:
    """Return the y that solves 0 = u(t, x, v, y), by Newton's method; NaN on paths where it fails.

    x and v may be complex, for a derivative by complex step: y then has the derivative of the solution, which one
    further update of Newton's method at the real solution gives exactly.

    Parameters
    ----------
    problem : DelaySDAE
    t : float
    x, v : ndarray, shape (d, P)
    guess : ndarray, shape (q, P) or (q, 1)

    Returns
    -------
    ndarray, shape (q, P)
    """
    constraint = problem.constraint
    assert constraint is not None
    real, lagged = np.real(x), np.real(v)

    def linearised(y: Array) -> tuple[Array, Array]:
        return constraint(t, real, lagged, y), problem.linearised_constraint(t, real, lagged, y).y

    begin = np.broadcast_to(guess, (len(guess), x.shape[-1]))
    root = newton(linearised, begin, update_tolerance(largest(begin), largest(real)))
    y = np.where(root.converged, root.x, np.nan)
    if not (np.iscomplexobj(x) or np.iscomplexobj(v)):
        return y
    return y - solve(linearised(y)[1], constraint(t, x, v, y))
