"""Weak orders with a delay without sampling."""

import numpy as np
import pytest

from facade import (
    StochasticTheta,
    delay_linear,
    delay_moment_errors,
    delay_ou,
    delay_test,
    known_moments,
    least_order,
    moment_orders,
    why_not_delay_moments,
)
from right.programmed_schemes import OwnHistory

STEPS = (8, 16, 32, 64, 128)


@pytest.mark.parametrize("theta", [0.0, 0.5, 1.0])
def test_the_theta_method_has_weak_order_one_and_its_means_two_at_one_half(theta: float) -> None:
    """On set II over four delays: E x of order 2 for theta = 1/2, E x^2 of order 1 for all."""
    record = delay_moment_errors(StochasticTheta(theta=theta), delay_test("II"), STEPS)
    first, second = (found.order for found in moment_orders(record))
    assert first == pytest.approx(2.0 if theta == 0.5 else 1.0, abs=0.02)
    assert second == pytest.approx(1.0, abs=0.02)
    assert least_order(moment_orders(record)) == pytest.approx((1.0, 1.0), abs=0.02)


def test_additive_noise_leaves_the_trapezoidal_rule_its_order_two() -> None:
    """On a mesh that the delay is a multiple of."""
    assert least_order(moment_orders(delay_moment_errors(StochasticTheta(), delay_ou(), STEPS))) == pytest.approx(
        (2.0, 2.0), abs=0.02
    )


def test_moments_are_known_by_their_values_and_needed() -> None:
    """Of x and x^2 in this order; on a nonlinear problem over several delays there are none."""
    assert known_moments(delay_test("I", horizon=0.5)) == pytest.approx(np.exp([-0.5, -0.5]), rel=1e-12)
    assert "do not provide" in why_not_delay_moments(StochasticTheta(), delay_test("IV"), STEPS)


def test_meshes_of_different_kinds_are_not_mixed() -> None:
    """With tau = 0.85 local orders of E x^2 would read 0.6, although errors are of order 1 on each kind of mesh."""
    assert "no multiple" in why_not_delay_moments(StochasticTheta(), delay_linear(tau=0.85), STEPS)
    record = delay_moment_errors(StochasticTheta(), delay_linear(tau=0.25), (2, 4, 8, 16, 32))
    assert record.h[0] == 0.25
    assert least_order(moment_orders(record)) == pytest.approx((1.0, 1.0), abs=0.02)


@pytest.mark.parametrize("right", [True, False])
def test_history_in_the_state_has_no_moment_equations(right: bool) -> None:
    """A state with as many components as a delay has steps would cost hours: paths judge the scheme."""
    assert "more components" in why_not_delay_moments(OwnHistory(right=right), delay_ou(), STEPS)
