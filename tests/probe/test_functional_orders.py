"""Orders of prescribed errors: what is told, what is left out, and what is left open."""

import numpy as np
import pytest

from facade import TransitionErrors, affine_constraint, functional_orders, least_order, order_of, widen

H = 2.0 ** -np.arange(3, 9)


def record(*errors, resolution=0.0, response=1.0, **noticed):
    """Return a record of errors of size 1 observables, to `resolution`; wrong steps change them by `response`."""
    columns = np.stack(errors, axis=1)
    seen = {name: np.zeros(len(H)) for name in ("departure", "failed", "truncated")} | noticed
    return TransitionErrors(
        h=H,
        steps=1.0 / H,
        errors=columns,
        exact=np.zeros(columns.shape[1]),
        spread=np.ones(columns.shape[1]),
        resolution=np.zeros_like(columns) + resolution,
        response=np.full(columns.shape[1], response),
        **seen,
    )


def only(*args, **kwargs):
    """Return what the only observable of a record says."""
    (found,) = functional_orders(record(*args, **kwargs))
    return found


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_an_order_is_extrapolated(order):
    """An error c h^p (1 + h) has order p to second order in h, and coefficient c."""
    found = only(-0.3 * H**order * (1.0 + H))
    # What remains of log2((1 + h)/(1 + h/2)) at the last two pairs is 3 h^2/log 2 for the finest h.
    assert found.order == pytest.approx(order, abs=4.4 * H[-1] ** 2)
    assert found.coefficient == pytest.approx(-0.3, rel=0.02)
    assert found.informative


def test_a_wrong_limit_has_order_zero():
    """An error that stays is no accident: it is used, and its order misses every claim."""
    found = only(0.1 + H)
    assert found.informative
    assert found.high < 0.2


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_interval_holds_what_the_floor_allows(sign):
    """Errors that are off by as much as their resolution leave the order inside its interval."""
    off = 1e-4 * sign * (-1.0) ** np.arange(len(H))
    found = only(H + off, resolution=1e-4)
    assert found.low <= 1.0 <= found.high
    assert found.order != pytest.approx(1.0, abs=0.01)


def test_a_change_of_sign_is_left_out():
    """An error h (h - h_0) with h_0 among the step sizes is uninformative, and so just beyond it."""
    for zero in (1.2 * H[-2], 1.02 * H[-4]):
        found = only(H * (H - zero))
        assert not found.informative
        assert found.resolved
        assert "changes sign" in found.note


def test_orders_that_move_keep_both_ends():
    """Local orders that differ by more than 0.3 have no limit yet: the last and the extrapolated one bound it."""
    found = only(H**2 + H * 2e-2 * np.exp(-((np.log2(H) + 8) ** 2)))
    assert "still changes" in found.note
    assert found.high - found.low > 0.3


def test_nothing_but_rounding_is_exact():
    """Errors below a floor of six digits have infinite order, whatever large steps do; below three digits none."""
    coarse = np.where(np.arange(len(H)) < 2, 1e-2, 1e-12)[:, None]
    found = only(1e-15 * np.ones(len(H)), resolution=coarse)
    assert found.order == np.inf
    assert found.informative
    assert not only(1e-15 * np.ones(len(H)), resolution=1e-3).resolved


def test_a_mean_that_a_symmetry_fixes_tells_nothing():
    """Without error at any step size, it is uninformative where wrong steps leave the mean, and exact where not."""
    for response, fixed in ((1e-14, True), (1e-3, False)):
        found = only(1e-15 * np.ones(len(H)), resolution=1e-12, response=response)
        assert found.fixed is fixed
        assert found.informative is not fixed
        assert "by symmetry" in found.note or found.order == np.inf
    assert least_order(functional_orders(record(H, 0.0 * H, response=0.0))) == pytest.approx((1.0, 1.0), abs=1e-7)


def test_a_mean_that_a_step_without_motion_keeps_is_not_said_to_be_fixed_by_a_symmetry():
    """The reason is what the step does; neither order nor bound rests on it."""
    unmoved = record(0.0 * H, response=0.0)
    (still,), (fixed,) = (functional_orders(each) for each in (unmoved._replace(still=np.ones(())), unmoved))

    assert still.note == "a step returns its state unchanged"
    assert still == fixed._replace(note=still.note)
    assert not still.informative
    assert fixed.note.startswith("by symmetry its mean is correct")


def test_orders_that_rise_have_no_upper_bound():
    """An error h/(1 + h/eps) on steps longer than eps has orders 0.05 to 0.6 that still rise; on others order 1."""
    coarse, fine = (only(H / (1.0 + H / eps)) for eps in (H[-1], 64.0 * H[0]))
    assert coarse.order < 0.85
    assert coarse.high == np.inf
    assert fine.high < 1.01


def test_orders_on_steps_that_do_not_resolve_the_fastest_time_have_no_upper_bound():
    """A constant error is a wrong limit; on steps that do not resolve the fastest time it is none."""
    found = functional_orders(record(0.1 + H))
    for eps, high in ((0.0, 0.0), (64.0 * H[-1], 0.0), (63.0 * H[-1], np.inf)):
        (seen,) = widen(found, affine_constraint(eps=eps, q=1))
        assert seen.order == 0.0
        assert seen.high == high


def test_a_small_error_that_stays_is_found():
    """Of h + h^2 + 1e-5 local orders are 1.00; what stays is a thousandth of the finest error."""
    found = only(H + H**2 + 1e-5)
    assert found.high == 0.0
    assert found.note.startswith("wrong limit: off by 1e-05 as h tends to 0")


def test_an_unresolved_observable_leaves_the_order_open():
    """What is hidden by the resolution could be the least order."""
    hidden = 1e-3 * np.ones(len(H))
    orders = functional_orders(TransitionErrors(*_with_resolution(record(H, hidden), [0.0, 1e-3])))
    assert not orders[1].resolved
    assert least_order(orders)[0] == -np.inf
    assert least_order(orders[:1]) == pytest.approx((1.0, 1.0), abs=1e-7)


def test_accidents_do_not_count_for_the_least_order():
    """An uninformative observable neither lowers nor opens it; without any other nothing is known."""
    orders = functional_orders(record(H, H * (H - 1.2 * H[-2])))
    assert least_order(orders) == pytest.approx((1.0, 1.0), abs=1e-7)
    assert least_order(orders[1:]) == (-np.inf, np.inf)


def test_failed_and_truncated_steps_raise_the_floor():
    """What they can change is their expected number times the size of the observable."""
    few = 1e-6 * np.array([4.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    floors = record(H, failed=few, truncated=2.0 * few).floors
    assert floors[:2, 0] == pytest.approx([12e-6 / H[0], 3e-6 / H[1]], rel=1e-6)
    assert floors[2:].max() < 1e-10


def test_a_floor_is_no_lower_than_at_the_next_step_sizes():
    """Two bases that agree by chance at one step size do not make its error known."""
    resolution = np.array([1e-3, 0.0, 1e-4, 0.0, 1e-5, 0.0])[:, None]
    floors = record(H)._replace(resolution=resolution).floors
    rounding = 64.0 * np.finfo(float).eps / H
    assert floors[:, 0] == pytest.approx(rounding + np.array([1e-3, 1e-4, 1e-4, 1e-5, 1e-5, 0.0]), rel=1e-12)


def test_numbers_that_are_not_finite_leave_coarse_steps_out():
    """An operator that overflows at large h tells nothing there, and spoils nothing below."""
    errors = np.where(np.arange(len(H)) < 2, np.nan, H)
    found = only(errors, resolution=np.where(np.isnan(errors), np.nan, 0.0)[:, None])
    assert found.order == pytest.approx(1.0, abs=1e-9)


def test_leaving_the_chart_is_an_obstacle():
    """Means are those of other states then."""
    assert "leaves the chart, by 0.01" in record(H, departure=1e-2 * (np.arange(len(H)) == 1)).why_not_evidence
    assert not record(H, departure=np.full(len(H), 1e-15)).why_not_evidence


def _with_resolution(given, columns):
    return given._replace(resolution=np.zeros_like(given.errors) + columns)


def test_an_order_that_falls_behind_a_change_of_sign_is_not_too_low():
    """Local orders 3.6 and 1.8 are on their way, and go up to 2 on steps that are below the floor here."""
    h, errors = 2.0 ** -np.arange(3.0, 6.0), np.array([1.9e-7, 1.6e-8, 4.7e-9])
    found = order_of(h, errors, np.full(3, 1e-12), 1.0)

    assert found.low < 0.2
    assert found.high == np.inf


def test_an_order_that_still_falls_a_little_is_no_lower_than_its_limit():
    """Local orders 1.88 and 1.79 have the limit 1.7, and nobody knows whether they go there."""
    h = 2.0 ** -np.arange(3.0, 6.0)
    errors = np.array([1.0, 2.0**-1.88, 2.0**-3.67])
    found = order_of(h, errors, np.full(3, 1e-12), 1.0)

    assert found.order == pytest.approx(1.7)
    assert (found.low, found.high) == pytest.approx((1.7, 1.88))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_no_order_is_too_low_where_next_to_nothing_of_a_mean_is_found(order, sign):
    """With E exp(-K h^p), or E exp(+K h^p), in place of E, local orders are far from p until K h^p is small."""
    for K in (0.1, 1.0, 10.0, 100.0):
        exact = 3.0
        errors = exact * np.expm1(sign * K * H**order)
        found = order_of(H, errors, np.full(len(H), 1e-12), exact, exact)
        assert found.high >= 0.9 * order


def test_orders_far_from_the_limit_are_told_from_wrong_limits():
    """A steady mean off by half of itself has order 0, an error c/h order -1, and the bias of a zero mean its own."""
    floors = np.full(len(H), 1e-12)
    assert order_of(H, 0.5 + H, floors, 1.0, 1.0).high < 0.2
    assert order_of(H, -1.0 + 0.0 * H, floors, 1.0, 1.0).high == np.inf
    assert order_of(H, 1.0 / H, floors, 1.0, 1.0).high < -0.8
    assert order_of(H, 3.0 * H, floors, 1.0, 0.0).high < 1.2
