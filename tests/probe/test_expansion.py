"""Coefficients of the lowest powers of an error: what is told, what is explained, and what is left open."""

import numpy as np
import pytest

from facade import lowest_power

H = 0.25 / 2.0 ** np.arange(5)
NONE = np.zeros(len(H))


def test_what_stays_is_told():
    """Of 0.5 + h + h^2 the limit 0.5 is left to rounding."""
    found = lowest_power(H, 0.5 + H + H**2, 1e-16 * np.ones(5), below=0.75)
    assert (found.power, found.value) == pytest.approx((0.0, 0.5), abs=1e-12)
    assert found.clear


@pytest.mark.parametrize("factor", [0.95, -3.0])
def test_an_error_of_order_one_leaves_nothing_behind(factor):
    """Errors a h + b h^2 + c (e^h - 1) of a scheme that claims order 2 have the right limit, and order 1."""
    errors = factor * H + 0.7 * H**2 + 0.3 * np.expm1(H)
    found = lowest_power(H, errors, NONE, below=1.75)
    assert found.power == 1.0
    assert found.value == pytest.approx(factor + 0.3, rel=1e-4)
    assert found.clear
    assert lowest_power(H, errors, NONE, below=0.75) is None


@pytest.mark.parametrize("order", [0.5, 1.5, 2.5])
def test_half_powers_are_eliminated_where_little_is_left(order):
    """Of h^p + h^(p + 1/2) nothing is left that half powers do not explain."""
    assert lowest_power(H, H**order + H ** (order + 0.5), NONE, below=order) is None


def test_terms_that_the_steps_do_not_resolve_leave_the_limit_open():
    """h/(1 + h/eps) with h from 16 eps on is no sum of the first powers of h: no limit is told from 0."""
    found = lowest_power(H, H / (1.0 + H / (H[-1] / 2.0)), NONE, below=0.75)
    assert found is None or not found.clear


def test_floors_are_part_of_what_is_not_known():
    """An error that stays is not told where it may be one of the projection."""
    errors = 1e-4 + H
    assert lowest_power(H, errors, NONE, below=0.75).clear
    assert lowest_power(H, errors, 1e-4 * np.ones(5), below=0.75) is None


def test_step_sizes_without_a_number_are_left_out():
    """What is not finite at coarse steps does not spoil the others; with fewer than four nothing is told."""
    errors = np.where(np.arange(5) < 1, np.nan, 0.5 + H)
    assert lowest_power(H, errors, NONE, below=0.75).value == pytest.approx(0.5)
    assert lowest_power(H, np.where(np.arange(5) < 2, np.nan, errors), NONE, below=0.75) is None
