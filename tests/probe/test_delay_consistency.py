"""Consistency of one step given its past, Definition 3.1."""

import numpy as np
import pytest

from facade import (
    DelayConsistency,
    StochasticTheta,
    consistency_order,
    delay_consistency,
    delay_ou,
    delay_test,
    local_strong,
    remove_delay,
    strong_orders,
)


@pytest.mark.parametrize("name", ["I", "II", "IV"])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_the_theta_method_is_consistent_of_order_one_half(name: str, theta: float) -> None:
    """Theorem 3.1."""
    order = consistency_order(delay_consistency(StochasticTheta(theta=theta), delay_test(name)))
    assert order == pytest.approx(0.5, abs=0.03)


def test_the_past_alone_limits_it_where_noise_is_additive() -> None:
    """Given its past a step is off by h^(3/2) in the mean; over the past, too, it is of order 1."""
    scheme, problem = StochasticTheta(theta=0.0), delay_ou()
    record = delay_consistency(scheme, problem)
    assert consistency_order(record) == pytest.approx(0.5, abs=0.01)
    last = np.log(record.mean.max(axis=0)[-2:])
    assert np.diff(last) / np.diff(np.log(record.h[-2:])) == pytest.approx(1.5, abs=0.01)
    assert strong_orders(local_strong(*remove_delay(scheme, problem)))[0].order == pytest.approx(1.0, abs=0.01)


def test_an_inconsistent_step_has_order_zero_or_less() -> None:
    """Defects of order h, which steps add up to order 0."""
    h = 2.0 ** -np.arange(4.0, 11.0)
    sizes = np.ones((3, 1)) * h
    record = DelayConsistency(h, sizes, sizes, np.ones((3, len(h))))
    assert consistency_order(record) == pytest.approx(0.0, abs=1e-12)
