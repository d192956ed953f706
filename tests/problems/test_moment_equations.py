"""Moments of problems without a known solution: observables on which the generator acts as a matrix."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from facade import circle, four_motions, noncommuting, product_force, sphere, spiral, three_motions
from problems.generator import generator, observed
from sdaeverify import Array, Moment, Problem

CASES: dict[str, Callable[[], Problem]] = {
    "circle": lambda: circle(2.0),
    "sphere": lambda: sphere(0.7, -0.4),
    "noncommuting": lambda: noncommuting(1.0, -0.8),
    "three motions": three_motions,
    "four motions": four_motions,
    "product force": lambda: product_force(0.7, -0.3, 1.4, 0.6, 0.9),
    "spiral": lambda: spiral(0.3, -1.0, 0.5, 0.2),
}


def moments(problem: Problem) -> dict[str, Moment]:
    return {truth.observable: truth for truth in problem.truths if isinstance(truth, Moment)}


def action(problem: Problem, names: list[str]) -> Array:
    """Return the matrix of the generator on (1, observables), fitted at random states on the manifold.

    Raises if the space of the observables is not invariant: the fit leaves more than the differences' error.
    """
    x = np.random.default_rng(3).standard_normal((problem.ito().dimension, 40))
    x = problem.admissible(x) if problem.has_constraints else x
    values = np.stack([np.ones(40), *(observed(problem, name)(x) for name in names)])
    images = np.stack([np.zeros(40), *(generator(problem, observed(problem, name), x) for name in names)])
    matrix, *_ = np.linalg.lstsq(values.T, images.T, rcond=None)
    assert np.abs(values.T @ matrix - images.T).max() <= 1e-9
    return matrix.T


def solved(problem: Problem, names: list[str], t: float) -> Array:
    """Return the expectations at time t by integrating m' = L m from the initial state."""
    L, x = action(problem, names), problem.initial(1)
    start = [1.0, *(float(observed(problem, name)(x)[0]) for name in names)]
    return solve_ivp(lambda _, m: L @ m, (0.0, t), start, rtol=1e-11, atol=1e-13).y[1:, -1]


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("t", [0.3, 1.7])
def test_moments_solve_the_equations_of_the_generator(name: str, t: float) -> None:
    """All known moments together are the solution of the linear equations that Ito's formula gives."""
    problem = CASES[name]()
    known = moments(problem)

    for value, moment in zip(solved(problem, list(known), t), known.values(), strict=True):
        assert moment.value(t) == pytest.approx(value, rel=1e-7, abs=1e-8), moment.observable
