"""Stable step sizes with a delay, against the sheet's numbers and known boundaries."""

import numpy as np
import pytest

from facade import (
    LARGE,
    SMALL,
    LaggedAlgebraicTheta,
    StochasticTheta,
    delay_linear,
    delay_stability,
    delay_test,
)
from facade import delay_equation_UNIT as UNIT
from facade import stability as scanning
from sdaeverify import Scheme

# Set, theta, spectral radius at h = 1/32 and growth rate for l = 0.


@pytest.fixture
def few_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scan few step sizes, where it is not the scan that is looked at."""
    monkeypatch.setattr(scanning, "PER_DECADE", 3)
    monkeypatch.setattr(scanning, "SMALLEST_M", range(1, 4))
    monkeypatch.setattr(scanning, "LONGER", 4)


@pytest.mark.usefixtures("few_sizes")
def test_without_an_acting_delay_the_boundary_is_that_of_the_plain_method() -> None:
    """On dx = a x dt + c x dW stability ends at -(2a + c^2)/(a^2 (1 - 2 theta))."""
    record = delay_stability(StochasticTheta(theta=0.2), delay_test("I"), [0.1], UNIT)
    assert record.windows == [(0.0, pytest.approx(1.0 / 0.6, rel=1e-9))]
    expected = ((1.0 - 0.8 * 0.1) ** 2 + 0.1) / (1.0 + 0.2 * 0.1) ** 2
    assert record.run.rho[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.usefixtures("few_sizes")
@pytest.mark.parametrize("scheme", [StochasticTheta, LaggedAlgebraicTheta])
def test_a_radius_at_the_end_of_its_bracket_is_found(scheme: type[Scheme]) -> None:
    """Set I has no delayed term, so that the gain is exactly c/r; Euler's method is stable for h < 1."""
    record = delay_stability(scheme(theta=0.0), delay_test("I"), [0.25], UNIT)
    assert record.windows == [(0.0, pytest.approx(1.0, rel=1e-9))]


def test_the_stable_steps_of_set_iv_are_no_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    """At small states with theta = 0: a window closes and opens again between two constrained meshes."""
    monkeypatch.setattr(scanning, "PER_DECADE", 2)
    monkeypatch.setattr(scanning, "SMALLEST_M", range(4, 7))
    monkeypatch.setattr(scanning, "LONGER", 2)
    record = delay_stability(StochasticTheta(theta=0.0), delay_test("IV"), [1 / 32], SMALL)
    (_, first), (second, last) = record.windows[:2]
    assert (first, second, last) == pytest.approx((0.199225, 0.201458, 0.239473), abs=1e-6)


@pytest.mark.slow
@pytest.mark.usefixtures("few_sizes")
def test_a_long_delay_is_scanned_down_to_the_equations_own_time() -> None:
    """A = -2, B = 1, tau = 400: Euler's method is unstable with 512 steps in a delay, and stable below h = .7365."""
    record = delay_stability(StochasticTheta(theta=0.0), delay_linear(tau=400.0), [0.1], UNIT)
    assert record.scan.h[0] == pytest.approx(0.1 / 4.0)
    assert record.scan.sign[0] < 0
    assert record.windows[0] == (0.0, pytest.approx(0.736455, abs=1e-6))
    assert record.run.rho[0] == pytest.approx(0.99970821217, abs=1e-10)


@pytest.mark.usefixtures("few_sizes")
def test_where_a_history_would_be_too_long_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """With tau = 40 the equation's own time asks for 1600 steps in a delay; fewer do not stand for them."""
    monkeypatch.setattr(scanning, "LONGEST", 40)
    monkeypatch.setattr(scanning, "LONG", 20)
    record = delay_stability(StochasticTheta(theta=0.0), delay_linear(tau=40.0), [0.1], UNIT)
    assert record.scan.h[0] == pytest.approx(0.1 / 4.0)
    assert np.isnan(record.scan.rho[0])
    assert record.scan.sign[0] == 0
    assert np.isnan(record.run.rho[0])


@pytest.mark.usefixtures("few_sizes")
def test_at_large_states_no_step_is_longer_than_the_delay() -> None:
    """The bounded term of the unknown would take part in the solve, and the step not be linear."""
    record = delay_stability(StochasticTheta(theta=1.0), delay_test("V"), [1 / 32], LARGE)
    assert record.scan.h.max() <= 1.0
    assert record.decays == 0.0


@pytest.mark.usefixtures("few_sizes")
@pytest.mark.parametrize(("d", "stable"), [(1.774, 1.0), (1.776, 0.0)])
def test_the_equations_own_boundary_is_met_on_both_sides(d: float, stable: float) -> None:
    """A = -2, B = 1, c = 0: |d| = 1.7749729938, and backward Euler keeps what is stable on short steps."""
    record = delay_stability(StochasticTheta(theta=1.0), delay_linear(A=-2.0, B=1.0, c=0.0, d=d), [1 / 8], UNIT)
    assert record.decays == stable
