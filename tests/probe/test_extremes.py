"""States far out: they are admissible, and as large as they are said to be."""

import numpy as np
import pytest

from facade import SCATTERED, SIZE, SIZES, circle, ou, pendulum
from probe.weak_cells import constant, equation
from sdaeverify.numerics import norm
from sdaeverify.probing import cloud, extreme_states


def test_velocities_grow_and_stay_tangent() -> None:
    """The cloud comes first; behind it velocities have the sizes from 1 to 1e8, tangent to rounding."""
    problem = pendulum()
    x = extreme_states(problem, problem.ito())
    r, v, _ = problem.state(x)

    assert x.shape[1] == SIZE + SCATTERED * len(SIZES)
    assert np.array_equal(x[:, :SIZE], cloud(problem, problem.ito()))
    assert norm(v[:, SIZE:]) == pytest.approx(np.tile(SIZES, SCATTERED), rel=1e-12)
    assert (np.abs((r * v).sum(axis=0)) <= 1e-10 * norm(v)).all()


def test_states_without_constraint_grow_as_a_whole() -> None:
    """An equation without constraints has states up to 1e8; one with an invariant has its cloud."""
    free, bound = ou(), circle()

    assert np.abs(extreme_states(free, free)).max() == pytest.approx(1e8)
    assert np.array_equal(extreme_states(bound, bound), cloud(bound, bound))


def test_states_without_finite_coefficients_are_left_out() -> None:
    """Where the drift overflows, nothing is asked of a step."""
    steep = equation(lambda t, x: -np.exp(x), constant([1.0]), [1.0])

    assert np.isfinite(np.exp(extreme_states(steep, steep))).all()
