"""The rates of one step at given states: how errors are measured, followed to shorter steps, and told."""

from dataclasses import replace

import numpy as np
import pytest

from cells import Formula
from conformance.test_run_memory import Unentered
from facade import (
    EulerMaruyama,
    KeptAlgebraic,
    StochasticTheta,
    compare_at,
    delay_test,
    double_well,
    gbm,
    law_resolution,
    rates_at,
    short_steps,
    state_words,
    step_laws,
)
from sdaeverify import SDE, Step
from sdaeverify.numerics.statistics import EPS
from sdaeverify.probing import OneStep
from test_noise_records import Queue, Served, queue

# The size of steps at which errors are first measured, those to which they are followed, and longer ones.
FIRST, FINER, LONGER = 4.0**-9, 4.0**-11, 4.0**-7
F, B = 1.0, 2.0
# Their size is theirs and a fifth of the typical one.
SIZE = 1.2 * np.array([F + B, B**2, B**2])


def plain(horizon=1.0):
    """Return dx = dt + 2 dW."""
    return SDE(
        drift=lambda t, x: np.full_like(x, F),
        diffusion=lambda t, x: np.full((1, 1, x.shape[1]), B),
        start=[1.0],
        noise_dim=1,
        horizon=horizon,
        source="test",
    )


def compared(off, x=(1.0,), horizon=1.0, strength=1.0, jumps=0.0):
    """Return the law of Euler's step with another drift, off(h, x), and a factor at the noise."""

    def rule(problem, x, h, noise):
        moved = h * (F + off(h, x)) + strength * B * noise.dW
        return x + moved + jumps * h * (noise.dW**2 > 1.44 * h) * (x > 100.0)

    return law_of(rule, x, horizon)


def law_of(rule, x, horizon=1.0):
    """Return the law of one step at some states."""
    step = OneStep(Formula(rule), plain(horizon))
    return compare_at(step, rates_at(step.view, step.equation, np.array([step.time]), np.array(x)[None, None]))


def sizes(law):
    """Return the errors of mean, covariance and covariance with the noise at the first state."""
    return law.off[:, 0, 0]


def is_wrong(law):
    """Return whether the mean has a wrong limit, at each state."""
    return law.wrong[0, 0].tolist()


class TestSizes:
    """Errors of rates that are too small to be followed."""

    def test_errors_are_relative_to_the_motion(self):
        """To |f| + |B|/sqrt(unit), to |B|^2 and to |B|, each with a fifth of the typical one."""
        drift = sizes(compared(lambda h, x: 1e-4))
        noise = sizes(compared(lambda h, x: 0.0, strength=1.0 + 2e-5))

        assert drift[0] == pytest.approx(1e-4 / SIZE[0], rel=1e-3)
        assert noise[1] == pytest.approx(4e-5 * B**2 / SIZE[1], rel=0.05)
        assert noise[2] == pytest.approx(2e-5 * B / np.sqrt(SIZE[2]), rel=1e-2)

    def test_noise_counts_by_the_unit_of_time(self):
        """On a horizon of a quarter it is the quarter."""
        found = sizes(compared(lambda h, x: 1e-4, horizon=0.25))

        assert found[0] == pytest.approx(1e-4 / (1.2 * (F + 2.0 * B)), rel=1e-3)

    def test_the_resolution_is_that_of_the_law_alone(self):
        """Half of the error of the covariance, and not that with the noise: its sign may be wrong."""
        drift = compared(lambda h, x: 2e-4)
        noise, sign = (compared(lambda h, x: 0.0, strength=value) for value in (1.0 + 4e-5, -1.0))

        assert drift.rate_error == pytest.approx(2e-4 / SIZE[0], rel=1e-3)
        assert noise.rate_error == pytest.approx(4e-5 * B**2 / SIZE[1], rel=0.05)
        assert sign.rate_error < 1e-5
        assert sign.departure == ""
        assert sign.wrong[2].all()

    def test_rounding_of_64_operations_is_taken_off(self):
        """That of a large state, over h from the mean, and with the noise from the covariance."""
        mean = sizes(compared(lambda h, x: 3e-4, (1e4,)))[0]
        explained = 64.0 * EPS * 1e4 / FIRST
        assert mean == pytest.approx((3e-4 - explained) / SIZE[0], rel=0.05)

        square = sizes(compared(lambda h, x: 0.0, (1e7,), strength=1.0 + 9.6e-5))[1]
        explained = 2.0 * 64.0 * EPS * 1e7 / np.sqrt(FIRST * SIZE[2])
        assert square == pytest.approx(19.2e-5 * B**2 / SIZE[1] - explained, rel=0.05)

        beyond = compared(lambda h, x: 0.0, (1e13,))
        assert (beyond.rate_error, is_wrong(beyond)) == (0.0, [False])


class TestLimits:
    """Errors that are followed to shorter steps."""

    @pytest.mark.parametrize(("part", "wrong"), [(1.05, True), (0.95, False)])
    def test_errors_from_a_ten_thousandth_on_are_followed(self, part, wrong):
        """Smaller ones are told as the resolution."""
        law = compared(lambda h, x: part * 1e-4 * SIZE[0])

        assert is_wrong(law) == [wrong]
        assert law.rate_error == pytest.approx(part * 1e-4, abs=6e-6)

    @pytest.mark.parametrize(
        ("power", "wrong"), [(0.0, True), (0.065, True), (0.071, False), (0.5, False), (1.0, False)]
    )
    def test_a_power_of_h_is_no_limit(self, power, wrong):
        """Its changes over factors of 16 are more than a quarter of the last one from the power 0.068 on."""
        assert is_wrong(compared(lambda h, x: 3.0 * h**power * (30.0 if power else 1.0))) == [wrong]

    @pytest.mark.parametrize(("power", "wrong"), [(0.0, True), (0.25, False), (0.5, False), (1.0, False)])
    def test_an_error_is_no_limit_while_the_move_itself_grows(self, power, wrong):
        """Noise divided by 1 + c h^p has the error 1 at all sizes if c is large, and so has noise divided by c."""

        def rule(problem, x, h, noise):
            return x + h * F + B * noise.dW / (1.0 + 10.0 * (h / 4.0**-15) ** power)

        assert law_of(rule, (1.0,)).wrong[1, 0].tolist() == [wrong]

    @pytest.mark.parametrize("power", [-0.3, -0.5, -1.0])
    def test_what_grows_as_steps_get_shorter_is_no_limit(self, power):
        """It is a solver's, whose moves have one size, or a scheme's whose order is too low."""
        assert is_wrong(compared(lambda h, x: 0.1 * (h / FIRST) ** power)) == [False]

    @pytest.mark.parametrize("unit", [1.0, 0.25])
    def test_errors_that_fall_are_followed_no_further_than_they_count(self, unit):
        """What is left of them is told at the first shorter size, in units of time."""
        law = compared(lambda h, x: 3000.0 * h, horizon=unit)

        assert is_wrong(law) == [False]
        assert sizes(law)[0] == pytest.approx(3000.0 * FINER * unit / (1.2 * (F + B / np.sqrt(unit))), rel=0.05)

    @pytest.mark.parametrize(("first", "wrong"), [(0.06, True), (0.04, False)])
    def test_what_grows_to_more_than_twice_is_no_limit(self, first, wrong):
        """From the first size to the shortest ones; at longer steps there is nothing."""
        off = compared(lambda h, x: 0.1 if h < 0.5 * FIRST else first if h < 2.0 * FIRST else 0.0)

        assert is_wrong(off) == [wrong]

    @pytest.mark.parametrize(("least", "wrong"), [(0.06, True), (0.04, False)])
    def test_longer_steps_show_a_limit_that_a_solver_hides(self, least, wrong):
        """If no shorter step has less than half of its error."""

        def off(h, x):
            if h > 2.0 * FIRST:
                return 0.1
            return least if h > FINER else 0.9 if h < 0.5 * FINER / 16.0 else 0.3

        assert is_wrong(compared(off)) == [wrong]

    @pytest.mark.parametrize(("states", "wrong"), [(5, 4), (4, 0)])
    def test_a_step_that_jumps_at_a_quarter_of_the_states_has_no_limit(self, states, wrong):
        """Two rules for its noise differ there; at fewer states the others count."""
        x = (*range(1, states), 1000.0)
        law = compared(lambda h, x: 0.3, x, jumps=3.0)

        assert sum(is_wrong(law)) == wrong


class TestWords:
    """How a deviation is told."""

    def test_the_largest_deviation_is_told_with_its_place(self):
        """And the number of points that deviate."""
        law = compared(lambda h, x: 0.3 * (x > 1.5) + 0.3 * (x > 2.5), (1.0, 2.0, 3.0))

        found = law.departure

        assert found.startswith("the mean of one step from [3], t = 0.2 is off by 0.17 of the motion of x at any h")
        assert found.endswith("at 2 of 3 points: wrong equation (Ito/Stratonovich?)")
        assert law.describe(np.zeros_like(law.wrong)) == ""

    def test_four_components_of_a_state_are_told(self):
        """More are not."""
        assert state_words(np.arange(4.0)) == "[0, 1, 2, 3]"
        assert state_words(np.arange(5.0)) == "[0, 1, 2, 3, ...]"

    @pytest.mark.parametrize("unit", [1.0, 0.25])
    def test_truncated_steps_are_not_compared(self, unit):
        """Where the shortest steps are truncated there is no limit yet."""

        def rule(problem, x, h, noise):
            return Step(x + h * (F + 0.3) + B * noise.dW, truncated=(x[0] > 1.5) & (h <= 1.01 * unit * 4.0**-15))

        law = law_of(rule, (1.0, 2.0, 3.0), unit)

        assert (law.points, is_wrong(law)) == (1, [True])

    def test_without_a_delay_there_is_one_comparison(self):
        """That of all steps of the run."""
        right = Formula(lambda problem, x, h, noise: x + h * F + B * noise.dW)

        assert [law.departure for law in step_laws(right, plain())] == [""]


class TestScope:
    """Which steps are compared."""

    @pytest.mark.parametrize("beside", [True, False])
    def test_steps_that_resolve_the_problem_are_compared(self, beside):
        """Those that are longer than its fastest time are not, nor those whose memory is unknown."""
        assert short_steps(EulerMaruyama(), gbm(), beside=beside) is not None
        assert short_steps(EulerMaruyama(), replace(gbm(), fastest_time=1e-9), beside=beside) is None
        assert short_steps(Unentered(), double_well(), beside=beside) is None

    @pytest.mark.parametrize(("times", "resolved"), [(65.0, True), (63.0, False)])
    def test_the_shortest_step_is_a_part_of_the_unit_of_time(self, times, resolved):
        """A fast time is 64 of them."""
        fast = replace(plain(horizon=0.25), fastest_time=times * 4.0**-15 * 0.25)

        assert (short_steps(EulerMaruyama(), fast) is not None) is resolved

    def test_a_resolution_needs_a_comparison(self):
        """Of steps, at points that move."""
        still = replace(plain(), drift=lambda t, x: 0.0 * x, diffusion=lambda t, x: 0.0 * x[:, None])

        assert law_resolution(EulerMaruyama(), gbm()).times == 32
        assert law_resolution(Unentered(), double_well()) is None
        assert law_resolution(EulerMaruyama(), still) is None

    def test_with_a_delay_a_step_needs_increments_and_its_x_alone(self):
        """A y that it keeps is memory, and areas one delay ago are not known."""

        class WithAreas(StochasticTheta):
            noise = frozenset({"dW", "H"})

        assert short_steps(StochasticTheta(), delay_test()) is not None
        assert short_steps(KeptAlgebraic(), delay_test()) is None
        assert short_steps(WithAreas(), delay_test()) is None


class Counted(Queue):
    """dx = dW + dN, whose Euler step counts arrivals."""

    def euler(self, t, x, h, noise):
        """Make a step of Euler's method."""
        return super().euler(t, x, h, noise) + noise.records["arrivals"]


class Late(Served):
    """A scheme that counts half of the arrivals."""

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return Step(super().step(problem, state, t, h, noise).state - 0.5 * noise.records["arrivals"])


class TestOtherNoise:
    """Noise beside Brownian motions."""

    def test_moments_of_other_noise_are_those_of_a_step_of_euler(self):
        """A wrong twin, which counts half of it, departs from them."""
        given = ("drift", "diffusion", "start", "noise_dim", "horizon", "source")
        problem = Counted(**{name: getattr(queue(), name) for name in given})
        right, wrong = (
            compare_at(OneStep(scheme, problem), rates_at(problem, problem, np.array([0.2]), np.ones((1, 1, 1))))
            for scheme in (Served(), Late())
        )

        assert (is_wrong(right), is_wrong(wrong)) == ([False], [True])
        assert right.rate_error < 1e-4
        assert short_steps(Served(), problem) is None
        assert short_steps(Served(), problem, beside=True) is not None
