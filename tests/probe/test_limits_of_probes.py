"""Limits of probes whose numbers follow from a bound, from either side of the bound."""

from dataclasses import replace

import numpy as np
import pytest

from facade import Apart, follows_coefficients, gbm, last_orders, signs, why_not_resolved
from sdaeverify import SDE
from sdaeverify.measures import uniform
from sdaeverify.measures import weak as weak_measure
from sdaeverify.probe.local.run_memory import PARTS

H = 4.0 ** -np.arange(2.0, 9.0)


class TestOrders:
    """Orders of the defects of one step."""

    @pytest.mark.parametrize(("power", "flat"), [(0.39, True), (0.41, False)])
    def test_small_defects_with_less_than_the_least_power_are_a_plateau(self, power, flat):
        """That of a wrong noise is 1/2; large defects are no plateau."""
        small, large = (size * H**power for size in (1e-7, 1e-3))

        found, other = (last_orders(H, sizes, np.zeros_like(H), np.ones_like(H)) for sizes in (small, large))

        assert (float(found.plateau_h) > 0.0) is flat
        assert float(other.plateau_h) == 0.0
        assert float(other.order) == pytest.approx(power)

    @pytest.mark.parametrize(("size", "settled"), [(0.3, True), (0.5, False)])
    def test_an_order_that_changes_by_less_than_a_twentieth_is_taken_from_further_levels(self, size, settled):
        """A correction like h^(1/2), whose changes halve from one level to the next, adds up to no more."""
        defects = H * (1.0 + size * (H / H[-3]) ** 0.5)

        found = last_orders(H, defects, np.zeros_like(H), np.ones_like(H), used=4)
        finest = np.log(defects[-2] / defects[-1]) / np.log(4.0)

        assert (abs(float(found.order) - finest) < 1e-9) == settled
        assert not settled or finest - 1.0 < 0.05


class TestMemory:
    """Differences of a run and one that is entered anew."""

    @staticmethod
    def stays(*sizes):
        """Return whether differences of these sizes stay, each at steps of a fourth of the size."""
        return Apart(("x",), tuple(np.full((1, PARTS), size) for size in sizes)).stays.any()

    @pytest.mark.parametrize(("size", "stays"), [(0.9e-3, False), (1.1e-3, True), (1.9, True), (2.1, False)])
    def test_differences_from_a_thousandth_to_twice_the_movement_count(self, size, stays):
        """Two independent runs differ by the root of 2 of their movement; larger differences are instabilities."""
        assert self.stays(size, size, size) is np.bool_(stays)

    @pytest.mark.parametrize(("part", "stays"), [(0.74, False), (0.76, True)])
    def test_differences_that_fall_to_three_quarters_vanish(self, part, stays):
        """Halfway between those of order 1/2 and those that stay; at any of the sizes."""
        assert self.stays(0.1, 0.1 * part, 0.1 * part) is np.bool_(stays)
        assert self.stays(0.1, 0.1, 0.1 * part) is np.bool_(stays)


class TestTime:
    """Steps that do not resolve a problem."""

    @pytest.mark.parametrize(("times", "resolved"), [(63.0, False), (65.0, True)])
    def test_a_fast_time_is_resolved_by_64_steps(self, times, resolved):
        """An order is then off by a hundredth."""
        h = 2.0**-12

        assert (why_not_resolved(replace(gbm(), fastest_time=times * h), h) == "") is resolved
        assert np.log2((1.0 + 1.0 / 64.0) / (1.0 + 1.0 / 128.0)) < 0.012

    @pytest.mark.parametrize(("angle", "followed"), [(1.0, True), (1.3, False)])
    def test_a_sine_is_followed_up_to_a_radian(self, angle, followed):
        """Of its argument in one step: sin^2 of a quarter of it times 4/pi is a tenth at 1.14."""
        h = 2.0**-6
        problem = SDE(
            drift=lambda t, x: np.sin(angle * t / h) + 0.0 * x,
            diffusion=lambda t, x: np.ones((1, 1, 1)),
            start=[1.0],
            noise_dim=1,
            horizon=1.0,
            source="test",
        )

        assert follows_coefficients(problem, h) is followed


class TestBounds:
    """Elementary bounds."""

    @pytest.mark.parametrize(("off", "sign"), [(0.9e-9, 0), (1.1e-9, 1)])
    def test_a_radius_is_known_to_a_thousand_times_the_agreement_of_two_rules(self, off, sign):
        """Nearer to 1 it does not decide."""
        assert signs(np.array([1.0 - off, 1.0 + off]), np.zeros(2)).tolist() == [-sign, sign]

    @pytest.mark.parametrize("p", [0.5, 1.0, 1.5, 2.0])
    def test_errors_of_two_powers_fall_more_than_half_as_fast_as_their_differences(self, p):
        """Whatever the size of the second term, if it has the same sign."""
        x = np.geomspace(1e-6, 1e6, 10_001)
        faster = x * (2.0 ** (p + 1.0) - 1.0) / (2.0**p - 1.0)
        errors, differences = ((p + (p + 1.0) * part) / (1.0 + part) for part in (x, faster))

        assert (errors / differences).min() > max(uniform.findings.LEVELLED, 0.68)

    @pytest.mark.parametrize("p", [0.5, 1.0, 2.0])
    def test_a_last_difference_bounds_the_error_up_to_a_factor(self, p):
        """As long as the second term takes less than the share of the first that its constant names."""
        r = (2.0 ** (p + 1.0) - 1.0) / (2.0**p - 1.0)
        s = np.linspace(-1.0 / (2.0 * r - 1.0), 10.0, 1001)

        assert ((1.0 + s) / (1.0 + r * s)).max() == pytest.approx(weak_measure.SLACK)
