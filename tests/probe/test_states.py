"""The cloud of states: where it is, and that the coefficients can be evaluated there."""

import numpy as np
import pytest

from facade import A_STRATUM, MOST_STEPS, SIZE, circle, fibre_clamped, gbm, pendulum, sphere
from facade import states_STRATA as STRATA
from probe.weak_cells import constant, equation
from sdaeverify import SDE, Problem
from sdaeverify.probing import cloud


def states(problem: Problem) -> np.ndarray:
    ito = problem.ito()
    assert isinstance(ito, SDE)
    return cloud(problem, ito)


@pytest.mark.parametrize(
    "problem", [gbm(), circle(), sphere(), pendulum()], ids=["gbm", "circle", "sphere", "pendulum"]
)
def test_the_cloud_begins_with_the_initial_state_and_spreads(problem: Problem) -> None:
    """The first state is the initial one; the others are finite and all different from each other."""
    x, ito = states(problem), problem.ito()

    assert x.shape == (ito.dimension, SIZE)
    assert np.array_equal(x[:, :1], ito.initial(1))
    assert np.isfinite(x).all()
    assert len(np.unique(np.round(x, 9), axis=1).T) == SIZE


@pytest.mark.parametrize("problem", [circle(), sphere(), pendulum()], ids=["circle", "sphere", "pendulum"])
def test_the_cloud_is_on_the_manifold(problem: Problem) -> None:
    """Constraint and hidden constraint hold to rounding."""
    residuals = problem.residuals(problem.parts(problem.state(states(problem))))

    for value, scale in residuals.values():
        assert np.all(np.abs(value) <= 1e-14 * np.maximum(1.0, scale))


def test_states_where_the_coefficients_are_not_finite_are_left_out() -> None:
    """A square root of the state keeps the cloud where it is real."""
    problem = equation(lambda t, x: 0.2 - x, lambda t, x: 0.8 * np.sqrt(x)[:, None], [0.05])

    x = states(problem)

    assert np.all(x >= 0.0)
    assert len(np.unique(x)) > SIZE // 2


def test_a_pilot_that_explodes_gives_the_initial_state() -> None:
    """A drift that Euler-Maruyama cannot follow leaves finite states, without a warning."""
    x = states(equation(lambda t, x: 1e3 * x**3, constant([1.0]), [3.0]))

    assert np.isfinite(x).all()
    assert np.all(np.abs(x) < 1e100)


def test_a_long_horizon_costs_no_more_than_a_short_one() -> None:
    """The pilot stops after so many steps, and so does the one that tells the unit of time, implicit or not."""
    calls = []

    def drift(t: float, x: np.ndarray) -> np.ndarray:
        calls.append(t)
        return -x

    problem = equation(drift, constant([1.0]), [1.0], horizon=1e4)
    calls.clear()
    states(problem)

    assert len(calls) <= MOST_STEPS + 4 * STRATA * A_STRATUM + 2 * STRATA + 8


def test_a_stiff_pilot_stays_where_solutions_are() -> None:
    """A stiff fibre moves at speeds of some units; explicit steps, however cut, led to 1e8."""
    problem = fibre_clamped(alpha=0.4, horizon=0.25)

    velocities = states(problem)[14:28]

    assert 1.0 < np.abs(velocities).max() < 30.0


def test_the_pilot_of_a_stiff_linear_equation_has_its_spread() -> None:
    """With dx = -10^6 x dt + 10^3 dW, of standard deviation 2^{-1/2}, no state is far outside of it."""
    stiff = equation(lambda t, x: -1e6 * x, constant([1e3]), [1.0])

    assert np.abs(states(stiff)).max() <= 1.0
