"""Suprema over eps of given errors, and their orders."""

import numpy as np
import pytest

from facade import UniformErrors, suprema

H = 0.1 * 0.5 ** np.arange(8)
EPS = 10.0 ** np.linspace(-8, 1, 19)


def record(error, floor=0.0, size=1.0):
    """Return the record of an error as a function of eps and h."""
    values = np.broadcast_to(error(EPS[:, None], H), (len(EPS), len(H)))[..., None]
    floors = np.broadcast_to(floor, values.shape[:2])[..., None]
    return UniformErrors(H, EPS, values, floors, np.full((len(EPS), 1), size))


def only(given):
    """Return the supremum of the only quantity."""
    (found,) = suprema(given)
    return found


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_order_of_a_uniform_error(order):
    """The order of C h^p is p, whatever eps is."""
    found = only(record(lambda eps, h: 3.0 * h**order))

    assert (found.order, found.least, found.most) == pytest.approx((order, order, order))


def test_plateaus_at_fixed_eps_do_not_matter():
    """C min(h, eps) has slope 0 at fixed eps < h, and its supremum has slope 1."""
    assert only(record(lambda eps, h: np.minimum(h, eps))).order == pytest.approx(1.0)


def test_an_error_at_h_equal_to_eps_is_a_plateau_of_the_supremum():
    """An error of size 1 wherever h = eps has order 1 for every eps and order 0 uniformly."""
    found = only(record(lambda eps, h: (h / eps) / (1.0 + (h / eps) ** 2)))

    assert abs(found.order) < 0.1
    assert found.most < 0.3


def test_floors_widen_the_order_and_end_it():
    """A floor of a tenth leaves the order open by log(1.1/0.9) over five octaves; one of a half leaves nothing."""
    found = only(record(lambda eps, h: 3.0 * h + 0.0 * eps, floor=0.3 * H))

    assert found.most - found.order == pytest.approx(np.log(1.1 / 0.9) / (5.0 * np.log(2.0)))
    assert not only(record(lambda eps, h: 3.0 * h + 0.0 * eps, floor=1.5 * H)).resolved


def test_infinite_errors_have_no_order():
    """An error that is infinite for a single eps is infinite in the supremum."""
    found = only(record(lambda eps, h: np.where(eps < 2e-8, np.inf, h)))

    assert found.order == -np.inf
    assert found.worst[-1] < 2e-8


def test_large_eps_are_left_out_where_they_are_not_known_and_small_ones_are_not():
    """What is not known for eps beyond ten times the longest step is not counted; for smaller ones it decides."""
    blurred = np.where(EPS[:, None] > 5.0, 1.0, 0.0) * np.ones_like(H)
    found = only(record(lambda eps, h: h + 0.0 * eps, floor=blurred))
    assert found.order == pytest.approx(1.0)
    assert found.left_out == pytest.approx([10.0])

    blurred = np.where(EPS[:, None] < 2e-8, 1.0, 0.0) * np.ones_like(H)
    assert not only(record(lambda eps, h: h + 0.0 * eps, floor=blurred)).resolved


def test_nothing_is_seen_below_a_millionth():
    """Errors and floors that are small beside the observed size are no errors."""
    assert not only(record(lambda eps, h: 1e-9 * h + 0.0 * eps)).seen
    assert only(record(lambda eps, h: 1e-4 * h + 0.0 * eps)).seen
