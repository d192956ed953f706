"""Local orders of defects that are known: powers of h, with rounding, plateaus and gaps."""

import numpy as np
import pytest

from sdaeverify.arrays import Array
from sdaeverify.probe.local.orders import LocalOrders, last_orders

H = 4.0 ** -np.arange(2.0, 9.0)
FINER = 4.0 ** -np.arange(2.0, 12.0)
ONE = np.ones_like(H)
FLOOR = 6e-14 * ONE


def orders(size: Array, used: int | None = None) -> LocalOrders:
    return last_orders(H, size, FLOOR, ONE, used)


def guarded(size: Array) -> LocalOrders:
    """Return orders from the first seven of ten levels."""
    return last_orders(FINER, size, 6e-14 + 0.0 * FINER, 1.0 + 0.0 * FINER, len(H))


@pytest.mark.parametrize("p", [0.5, 1.0, 1.5, 2.5])
def test_the_order_of_a_power_is_its_exponent(p: float) -> None:
    """A pure power of h has its exponent as order, now and ahead, and no plateau."""
    found = orders(0.3 * H**p)

    assert found.order == pytest.approx(p, abs=1e-12)
    assert found.ahead == pytest.approx(p, abs=1e-12)
    assert found.plateau_h == 0.0


def test_the_order_is_taken_above_the_floor() -> None:
    """Rounding errors at the finest levels do not enter."""
    found = orders(np.maximum(H**3.0, 1e-14))

    assert found.order == pytest.approx(3.0, abs=1e-12)


@pytest.mark.parametrize("size", [0.0 * H, 1e-15 * ONE, np.where(H > 0.05, 1e-10, 1e-16)])
def test_what_is_rounding_on_all_levels_but_one_has_infinite_order(size: Array) -> None:
    """Fewer than two levels above the floor are exact."""
    assert orders(size).order == np.inf


@pytest.mark.parametrize("first", [0, 3, 6])
def test_a_defect_that_is_not_finite_at_the_finest_level_has_no_order(first: int) -> None:
    """From some level on not finite: no order; at coarse levels only: the order of the others."""
    levels = np.arange(len(H))

    assert np.isnan(orders(np.where(levels >= first, np.nan, H)).order)
    if first < 6:
        assert orders(np.where(levels < first, np.inf, H)).order == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("plateau", [3e-9, 1e-8, 1e-7])
def test_a_plateau_is_dropped_with_all_that_it_disturbs(plateau: float) -> None:
    """Levels within a factor 30 of the plateau go, and the largest of their h is reported."""
    size = FINER**1.5 + plateau

    found = guarded(size)

    assert found.order == pytest.approx(1.5, abs=0.03)
    assert found.plateau_h == FINER[size <= 30.0 * size[-2]][0]


def test_a_plateau_above_any_tolerance_is_an_order() -> None:
    """Errors of 1e-5 that do not decrease are no tolerance: the order is 0."""
    found = orders(H**1.5 + 1e-5)

    assert found.order == pytest.approx(0.0, abs=0.05)
    assert found.plateau_h == 0.0


def test_a_plateau_on_all_levels_leaves_no_order() -> None:
    """Where nothing but the tolerance is seen there is no order."""
    assert np.isnan(orders(1e-8 * ONE).order)


def test_a_slow_but_steady_decrease_is_no_plateau() -> None:
    """A relative error 1e-7 of the noise has order 1/2 and keeps it."""
    assert orders(1e-7 * np.sqrt(H)).order == pytest.approx(0.5, abs=1e-12)


def test_finer_levels_show_a_plateau_that_begins_at_the_last_one() -> None:
    """Levels that are used for no order tell a plateau from a lower order."""
    size = FINER**2.0 + 2e-10
    assert orders(size[: len(H)]).order < 1.7

    found, other = guarded(size), guarded(1e-3 * FINER**2.0 + 1e-8 * FINER)

    assert found.order == pytest.approx(2.0, abs=0.03)
    assert found.plateau_h > 0.0
    assert other.order < 1.9
    assert other.plateau_h == 0.0


def test_an_order_that_changes_is_carried_on() -> None:
    """Between two powers, the order ahead lies on the side of the lower one."""
    found = orders(H**2.0 + 1e-4 * H)

    assert 1.0 < found.order < 2.0
    assert found.ahead < found.order


def test_many_defects_are_treated_one_by_one() -> None:
    """Any leading shape gives the orders of each defect alone."""
    sizes = np.stack([H**1.0, 0.0 * H, H**1.5 + 1e-8, np.full_like(H, np.nan)])
    together = last_orders(H, sizes, FLOOR, ONE)

    for k, size in enumerate(sizes):
        alone = orders(size)
        assert np.array_equal([part[k] for part in together], list(alone), equal_nan=True)
