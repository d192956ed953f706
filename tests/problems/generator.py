"""The generator of a problem's Ito equation, by differences of order eight."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, Problem
from sdaeverify.testing.checks.differences import first, second

Function = Callable[[Array], Array]


def observed(problem: Problem, name: str) -> Function:
    """Return an observable at time 0 as a function of the state's rows, shape (d, P) -> (P,)."""
    equation = problem.ito()
    assert equation is not None

    def value(x: Array) -> Array:
        return np.asarray(problem.observables[name](0.0, equation.parts(x)))

    return value


def generator(problem: Problem, q: Function, x: Array) -> Array:
    """Return L q = Dq f + (1/2) sum_j D^2 q(B_j, B_j) at the columns of x, shape (P,)."""
    equation = problem.ito()
    assert equation is not None
    B = np.broadcast_to(equation.diffusion(0.0, x), (len(x), equation.noise_dim, x.shape[1]))
    return np.asarray(first(q, x, equation.drift(0.0, x)) + 0.5 * sum(second(q, x, b) for b in np.moveaxis(B, 1, 0)))
