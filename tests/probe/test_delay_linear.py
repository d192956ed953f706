"""The matrices of a step with a delay, found by evaluating it, against the closed form of the theta method."""

from dataclasses import replace

import numpy as np
import pytest

from facade import (
    AFFINE,
    LARGE,
    SMALL,
    LaggedAlgebraicTheta,
    StochasticTheta,
    at_rest,
    delay_ou,
    delay_test,
    is_autonomous,
    limits,
    linear_delay,
    probe_step,
)
from facade import delay_equation_UNIT as UNIT
from probe.theta_cells import SETS
from sdaeverify import DelaySDAE

# 1/theta-cell inverses of moderate condition, a few operations each.
ROUNDING = 1e-13


@pytest.mark.parametrize("name", ["I", "II", "III"])
@pytest.mark.parametrize("theta", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("h", [0.125, 0.3, 0.7, 1.6])
def test_a_linear_step_is_found_as_it_is(name: str, theta: float, h: float) -> None:
    """On every kind of mesh, with the delay shorter than a step, too."""
    cell = SETS[name]._replace(l=0.0)
    found = probe_step(StochasticTheta(theta=theta), delay_test(name, l=0.0), h)
    expected = cell.step(theta, h)
    assert found.defect <= AFFINE
    assert not found.failed
    assert not found.offset.any()
    assert found.step.drift == pytest.approx(expected.drift, abs=ROUNDING * np.abs(expected.drift).max())
    assert found.step.noise == pytest.approx(expected.noise, abs=ROUNDING * np.abs(expected.drift).max())


def test_a_lagged_algebraic_component_shows_in_its_own_column() -> None:
    """With theta = 1 the old y drives x, where the coupled method takes nothing from it."""
    problem, h = delay_test("IV", l=0.0), 0.125
    old, coupled = (probe_step(s(theta=1.0), problem, h).step for s in (LaggedAlgebraicTheta, StochasticTheta))
    assert old.drift[0, 1] == pytest.approx(h / (1.0 + 8.0 * h), rel=1e-13)
    assert coupled.drift[0, 1] == 0.0


@pytest.mark.parametrize("name", ["III", "IV", "V", "VI"])
def test_a_sine_is_its_derivative_at_small_states_and_nothing_at_large_ones(name: str) -> None:
    """The two limits are the linearised equation and that with l = 0; neither is the equation itself."""
    cell, problem, scheme = SETS[name], delay_test(name), StochasticTheta(theta=0.5)
    assert limits(scheme, problem, 0.25) == (SMALL, LARGE)
    assert linear_delay(problem, SMALL)[:4] == pytest.approx(cell.equation[:4], rel=1e-12)
    assert linear_delay(problem, LARGE)[:4] == pytest.approx(cell._replace(l=0.0).equation[:4], rel=1e-12)
    for size, l in ((SMALL, cell.l), (LARGE, 0.0)):
        expected = cell._replace(l=l).step(0.5, 0.25).drift
        assert probe_step(scheme, problem, 0.25, size).step.drift == pytest.approx(expected, abs=1e-12)


def test_additive_noise_is_an_offset() -> None:
    """Of the noise, per standard deviation; the equation is then not at rest at zero."""
    problem, h = delay_ou(sigma=0.7), 0.125
    found = probe_step(StochasticTheta(theta=0.0), problem, h)
    assert found.offset == pytest.approx(np.array([[0.0], [0.7 * np.sqrt(h)]]), abs=1e-15)
    assert not at_rest(problem)
    assert at_rest(delay_test())


def test_coefficients_that_depend_on_time_are_seen() -> None:
    """In the drift; those of the test problem do not."""
    problem = delay_test("II")
    assert is_autonomous(problem)
    assert limits(StochasticTheta(), problem, 0.25) == (UNIT,)
    moving: DelaySDAE = replace(problem, drift=lambda t, x, v, y: -x * (1.0 + t), drift_partials=None)
    assert not is_autonomous(moving)
