"""The law of increments with few values is found point by point, and tells what a jump makes of an order."""

from dataclasses import replace
from itertools import product
from math import comb
from typing import ClassVar

import numpy as np
import pytest
import scipy

from facade import EulerMaruyama, PlatenWeak2, delay_ou, double_well, gbm, noncommuting, pendulum
from sdaeverify import TWO_POINT, Increment, Law
from sdaeverify.probe.operator.point_law import PointLaw, largest_errors_order, point_law, why_not_point_law


class Coins(EulerMaruyama):
    """Euler-Maruyama with +-sqrt(h) in place of dW."""

    name: ClassVar[str] = "coins"
    law: ClassVar[Law] = TWO_POINT


def seen(problem, **functions):
    """Return the problem with other observables, functions of its first component."""
    made = {name: (lambda t, s, q=q: q(s["x"][0])) for name, q in functions.items()}
    return replace(problem, observables=made, truths=(), controls=())


@pytest.mark.sweep
@pytest.mark.parametrize("doubled", range(4))
@pytest.mark.parametrize("place", [0, 3])
def test_the_law_of_a_walk_is_binomial(doubled, place):
    """(1 + a h + b sqrt(h))^k (1 + a h - b sqrt(h))^(N - k) has the probability C(N, k)/2^N."""
    record = point_law(Coins(), seen(gbm(0.5, 0.6), above=lambda x: 1.0 * (x > 1.0), square=np.square), 8)
    number = 8 * 2**doubled + 8 * 2**doubled * place // 7
    h, k = 1.0 / number, np.arange(number + 1)
    up, down = 1.0 + 0.5 * h + 0.6 * np.sqrt(h), 1.0 + 0.5 * h - 0.6 * np.sqrt(h)
    x, p = up**k * down ** (number - k), np.array([comb(number, i) for i in k], dtype=float) / 2.0**number

    assert record.h[doubled] == 1.0 / (8 * 2**doubled)
    assert record.means[doubled, place] == pytest.approx([p @ (x > 1.0), p @ x**2], rel=1e-9)


def test_of_points_that_do_not_meet_all_are_followed():
    """Eight steps of two motions with three atoms each would be 9^8 points: of them nothing is found."""
    well, pair = (point_law(PlatenWeak2(), problem, 4) for problem in (double_well(), noncommuting()))
    h = 0.25 * double_well().horizon
    atoms = product(zip((-(3.0**0.5), 0.0, 3.0**0.5), (1 / 6, 2 / 3, 1 / 6), strict=True), repeat=4)
    xi, weights = map(np.array, zip(*(zip(*path, strict=True) for path in atoms), strict=True))
    x = double_well().initial(len(xi))
    for step, dW in enumerate(np.sqrt(h) * xi.T):
        x = PlatenWeak2().prepare(double_well(), h)(x, step * h, Increment(dW[None], None)).state

    assert well.means[0, 0, 1] == pytest.approx(weights.prod(axis=1) @ x[0] ** 2, rel=1e-9)
    assert len(well.h) == 1
    assert not len(pair.h)


def test_points_on_a_jump_blur_a_mean():
    """A walk of even length comes back to where it began: whether that is beyond the jump is rounding."""
    start = float(gbm().initial(1)[0, 0])
    flat = replace(gbm(0.0, 0.0), diffusion=lambda t, x: np.ones((1, 1, x.shape[1])))
    record = point_law(
        Coins(), seen(flat, above=lambda x: 1.0 * (x > start), beside=lambda x: 1.0 * (x > start + 0.01)), 8
    )

    assert record.blur[0, 0] == pytest.approx([scipy.special.comb(8, 4) / 2**8, 0.0])


H = 2.0 ** -np.arange(3.0, 7.0)
# By numbers of steps between N and 2N: the largest one is 1.
FACTORS = ([1, 1, 1], [-1, 0, 0.3], [0.1, -0.2, 1])


def lattice(errors, blur=0.0):
    """Return means 1 + e of one observable."""
    return PointLaw(H[: len(errors)], 1.0 + errors[..., None], np.full((*errors.shape, 1), blur))


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_the_order_of_errors_is_that_of_the_largest(order):
    """Errors that vanish or change their sign by accident do not hide it."""
    for shift in range(3):
        errors = np.array([np.roll(FACTORS[(k + shift) % 3], k) for k in range(4)]) * H[:, None] ** order

        assert largest_errors_order(lattice(errors), 0, 1.0) == pytest.approx(order)


def test_what_is_not_known_of_errors_lowers_no_order():
    """Few step sizes tell none, and a mean that may be off by all of its error may be of any."""
    errors = np.ones(3) * H[:, None]

    assert largest_errors_order(lattice(errors, 1.0), 0, 1.0) == np.inf
    assert largest_errors_order(lattice(np.array([1.0, -1.0]) * H[:, None]), 0) == pytest.approx(1.0)
    assert np.isnan(largest_errors_order(lattice(errors[:2]), 0, 1.0))


@pytest.mark.parametrize(
    ("scheme", "problem", "why"),
    [
        (EulerMaruyama(), gbm(), "gaussian increments"),
        (Coins(), seen(gbm()), "no observables"),
        (Coins(), delay_ou(), "is not discrete"),
        (Coins(), gbm(), ""),
    ],
)
def test_other_laws_are_left_alone(scheme, problem, why):
    """Normal increments have no points, and a past is no state."""
    found = why_not_point_law(scheme, problem)

    assert (why in found) if why else not found


def test_an_observable_of_an_unknown_component_has_no_mean():
    """The others have theirs."""
    view = Coins().view_of(pendulum())
    means = dict(zip(view.observables, point_law(Coins(), view, 4).means[0, 0], strict=True))

    assert np.isnan(means["mu"])
    assert np.isfinite(means["r_1"])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_no_lattice_hides_a_whole_order(seed):
    """Of jumps and kinks at random places, by two schemes, no order is found more than 1 below the true one."""
    rng = np.random.default_rng(seed)
    for _ in range(14):
        a, b = rng.uniform(-1.0, 1.0), rng.uniform(0.1, 1.0)
        places = np.exp(b * rng.uniform(-2.0, 2.0, 16) + a - 0.5 * b * b)
        jumps = {f"jump {k}": lambda x, k=k: 1.0 * (x > k) for k in places}
        kinks = {f"kink {k}": lambda x, k=k: np.maximum(x - k, 0.0) for k in places}
        d = (a - 0.5 * b * b - np.log(places)) / b
        ndtr = scipy.special.ndtr
        exact = [*ndtr(d), *(np.exp(a) * ndtr(d + b) - places * ndtr(d))]
        for scheme in (Coins(), PlatenWeak2()):
            record = point_law(scheme, seen(gbm(a, b), **jumps, **kinks), 8)
            orders = [largest_errors_order(record, place, mean) for place, mean in enumerate(exact)]

            assert min(orders[:16]) > 0.5 - 1.0
            assert min(orders[16:]) > 1.0 - 1.0
