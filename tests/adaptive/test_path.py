"""A Brownian path by random access: its law below the grid, and that it is one path however it is asked."""

import numpy as np
import pytest
import scipy

from adaptive.solving import path
from sdaeverify import UsageError
from sdaeverify.studying import Brownian, Source
from sdaeverify_adaptive import TICKS, brownian_path
from sdaeverify_adaptive.hashed import normals
from sdaeverify_adaptive.path import GRID, PER_STEP

# Two-sided normal quantile that a right path exceeds once in 10^6 tests.
QUANTILE = float(scipy.special.ndtri(1.0 - 0.5e-6))


@pytest.fixture(scope="module")
def two():
    return path(2, 40)


def test_any_order_of_questions_gives_the_same_bits(two):
    """A path asked backwards, forwards, or on some rows alone has the same W and J at the same ticks."""
    rng = np.random.default_rng(1)
    ticks = rng.integers(0, TICKS + 1, (6, 40))
    once = [two.at(tick) for tick in ticks]
    rows = rng.permutation(40)[:7]

    for number in reversed(range(6)):
        again, some = two.at(ticks[number]), two.only(rows).at(ticks[number, rows])
        for part in ("W", "J"):
            assert np.array_equal(getattr(once[number], part), getattr(again, part))
            assert np.array_equal(getattr(once[number], part)[:, rows], getattr(some, part))


def test_a_path_at_an_address_is_always_the_same():
    """Two paths of one source agree to the last bit between grid times, those of another block do not."""
    source, tick = Source(3, "gbm", 0, 20), np.arange(20) * 50021
    first, second = (brownian_path(source, 1, 1.0).at(tick).W for _ in range(2))
    other = brownian_path(source._replace(block=1), 1, 1.0).at(tick).W

    assert np.array_equal(first, second)
    assert not np.any(first[:, 1:] == other[:, 1:])


def test_the_path_is_that_of_fixed_steps():
    """Increments and areas over the steps of each level are those that the package draws, up to rounding."""
    source = Source(5, "ou", 0, 8)
    mine = brownian_path(source, 2, 1.0)
    first = next(Brownian(source, 2, 1.0 / 16, 9).steps())

    for level in (0, 4, 9):
        stride, noise = TICKS // (16 * 2**level), first[level].increment(0)
        found = mine.between(mine.at(0), mine.at(stride))
        assert np.allclose(found.dW, noise.dW, rtol=0.0, atol=1e-13)
        assert np.allclose(found.H, noise.H, rtol=0.0, atol=1e-13 * 16 * 2**level)


def test_neighbouring_ticks_have_the_law_of_brownian_motion():
    """Over one and over two ticks below the grid, dW and H have variances h and h/12, and no correlation."""
    wide, rng, h = path(1, 400), np.random.default_rng(2), 1.0 / TICKS
    scaled = []
    for begin in rng.integers(0, TICKS - 4, (10, 400)):
        a, b, c = (wide.at(begin + step) for step in (0, 1, 2))
        first, second, both = wide.between(a, b), wide.between(b, c), wide.between(a, c)
        known = (first.dW, second.dW, both.dW / np.sqrt(2), first.H * np.sqrt(12), both.H * np.sqrt(6))
        scaled.append(np.concatenate(known) / np.sqrt(h))
    of_one = np.concatenate(scaled, axis=1)

    for each in of_one:
        assert abs(np.mean(each)) < QUANTILE / np.sqrt(4000)
        assert abs(np.mean(each**2) - 1.0) < QUANTILE * np.sqrt(2.0 / 4000)
    for one, other in ((0, 1), (0, 3), (2, 4)):
        assert abs(np.mean(of_one[one] * of_one[other])) < QUANTILE / np.sqrt(4000)


@pytest.mark.slow
def test_the_law_at_the_finest_tick_on_many_paths():
    """On 20000 paths the variance over one tick is 1 and the correlation of neighbours 0, within five errors."""
    blocks = [brownian_path(Source(7, "law", block, 4000), 1, 1.0) for block in range(5)]
    begin = np.random.default_rng(3).integers(0, GRID, 4000) * PER_STEP + 1
    points = [[each.at(begin + step).W[0] for each in blocks] for step in (0, 1, 2)]
    a, b, c = (np.concatenate(each) for each in points)
    first, second = np.sqrt(TICKS) * (b - a), np.sqrt(TICKS) * (c - b)

    assert abs(np.mean(first**2) - 1.0) < 5 * np.sqrt(2 / 20000)
    assert abs(np.mean(first * second)) < 5 / np.sqrt(20000)


def test_an_area_is_the_time_integral_of_the_path_between(two):
    """J over four ticks is that of its halves put together, and H is what is left of it."""
    begin, middle, end = (two.at(np.arange(40) * 1000 + step) for step in (1, 3, 5))
    whole, first, second = (two.between(a, b) for a, b in ((begin, end), (begin, middle), (middle, end)))
    h = 2.0 / TICKS

    joined = first.time_integral(h) + h * first.dW + second.time_integral(h)
    assert np.allclose(whole.time_integral(2 * h), joined, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("tick", [-1, TICKS + 1, 0.5, np.array([1.5])])
def test_what_is_no_tick_is_refused(two, tick):
    """Nothing is known below the finest tick or outside of the horizon, and nothing is interpolated."""
    with pytest.raises(UsageError, match="whole ticks"):
        two.at(tick)


def test_times_are_ticks_or_refused(two):
    """A time is a tick up to rounding, and half a tick is an error that says how fine the path is."""
    times = 0.1 + 0.2 - np.array([0.1, 0.2]) - np.array([0.2, 0.1]) + 3 * two.tick

    assert np.array_equal(two.ticks_of(times), [3, 3])
    for wrong in (0.5 * two.tick, 1.0 + two.tick, -two.tick):
        with pytest.raises(UsageError, match=r"multiples of 9\.53674e-07"):
            two.ticks_of(wrong)


def test_hashed_normals_are_normal_and_independent():
    """At neighbouring addresses, rows and places they have mean 0, variance 1, kurtosis 3 and no correlation."""
    rows = np.arange(200)
    drawn = np.stack([normals(11, np.full(200, node), rows, (2, 3)) for node in range(100)])
    n = drawn.size
    flat = drawn.ravel()

    assert abs(flat.mean()) < QUANTILE / np.sqrt(n)
    assert abs((flat**2).mean() - 1.0) < QUANTILE * np.sqrt(2.0 / n)
    assert abs((flat**4).mean() - 3.0) < QUANTILE * np.sqrt(96.0 / n)
    for a, b in ((drawn[1:], drawn[:-1]), (drawn[..., 1:], drawn[..., :-1]), (drawn[:, 0], drawn[:, 1])):
        assert abs((a * b).mean()) < QUANTILE / np.sqrt(a.size)
