"""The leading term of an error is found by extrapolation, and is known as well as is said."""

import numpy as np
import pytest

from facade import gbm, leading_error, moment_errors, observable_errors, order_of, quadratic_form
from sdaeverify import Settings
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

H = 2.0 ** -np.arange(3.0, 12.0)
NONE = np.zeros(len(H))


@pytest.mark.parametrize("order", [0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("seed", range(8))
def test_the_constant_is_known_as_well_as_is_said(order, step, seed):
    """Of sums of powers h^(p + k step) with random coefficients and rounding, the first coefficient is found."""
    rng = np.random.Generator(np.random.Philox(key=seed))
    coefficients = rng.uniform(-1.0, 1.0, 6)
    powers = order + step * np.arange(6)
    exact = (coefficients[:, None] * H ** powers[:, None]).sum(axis=0)
    floors = np.full(len(H), 1e-13)
    found = leading_error(H, exact + rng.uniform(-1.0, 1.0, len(H)) * floors, floors, order + 0.01)

    assert found is None or found.power == order
    assert found is None or abs(found.value - coefficients[0]) <= found.known
    assert found is not None or abs(coefficients[0]) < 0.3


def test_further_terms_of_another_kind_are_not_hidden():
    """With a power that is no multiple of 1/2, the error that is told covers what it changes."""
    found = leading_error(H, H + 0.5 * H**1.25, NONE, 1.0)

    assert found is None or abs(found.value - 1.0) <= found.known


@pytest.mark.parametrize("order", [np.nan, np.inf, 0.0, 0.1, 2.0])
def test_no_constant_without_an_order(order):
    """An error without an order, a wrong limit, or another order than is said has no constant."""
    assert leading_error(H, 0.3 * H**1.5, NONE, order) is None


def test_errors_below_their_floors_have_none():
    """Four step sizes in a row are needed at which the error is known to a digit."""
    floors = np.where(np.arange(len(H)) % 4 == 0, 1.0, 0.0)

    assert leading_error(H, H, floors, 1.0) is None
    assert leading_error(H, H, NONE, 1.0).value == pytest.approx(1.0)


def test_euler_maruyama_on_geometric_brownian_motion():
    """E x_n = (1 + a h)^n and E x_n^2 = (1 + (2 a + b^2) h + a^2 h^2)^n give C = -T e^(rT) (r^2/2 - s), exactly."""
    problem = gbm()
    record = moment_errors(EulerMaruyama(), problem, Settings().steps)
    a, b, T = 0.5, 0.6, problem.horizon

    for name, rate, second in (("x", a, 0.0), ("x^2", 2.0 * a + b**2, a**2)):
        errors = observable_errors(record, quadratic_form(problem, name))
        found = leading_error(*errors[:3], order_of(*errors).order)
        exact = -T * np.exp(rate * T) * (0.5 * rate**2 - second)
        assert found.power == 1.0
        assert abs(found.value - exact) <= found.known <= 1e-4 * abs(exact)
