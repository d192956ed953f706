"""A step with a delay is probed after the second delay as before it, and with the history where only that can be."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    DIFFERENT,
    FIRST,
    SECOND,
    WHOLE,
    StochasticTheta,
    delay_linear,
    delay_moment_errors,
    delay_test,
    judge_strong,
    judge_weak,
    keeps_constraint,
    least_order,
    local_weak,
    moment_orders,
    probe_weak,
    remove_delay,
    weak_order,
    why_not_delay_moments,
    why_not_delay_stability,
    why_not_lasting_run,
    why_not_lasting_step,
)
from probe.strong_cells import probed
from sdaeverify import DelaySDAE, DelayState, Increment, Problem, Scheme, Settings, Step
from sdaeverify.measuring import Verdict
from sdaeverify_lab.planted.delays import LateLag

STEPS = (8, 16, 32, 64, 128)


@dataclass(frozen=True)
class KnowsHistory(StochasticTheta):
    """Up to the first delay the past is taken from the problem, off by some part of it, whatever is given."""

    theta: float = 0.0
    off: float = 0.0

    name: ClassVar[str] = "knows-history"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        if t < problem.delay - 1e-9:
            lagged, ahead = (
                (1.0 + self.off) * problem.past(min(0.0, s - problem.delay)) + 0.0 * state.x for s in (t, t + h)
            )
            noise = noise._replace(lagged=lagged, ahead=ahead)
        return super().step(problem, state, t, h, noise)


def test_a_lag_that_is_lost_late_is_refuted() -> None:
    """On set II over four delays, where half of the mean is missing at the end, by strong and by weak order."""
    wrong, problem = LateLag(since=3.5), delay_test("II", horizon=4.0)
    pair = remove_delay(wrong, problem)

    assert judge_strong(probed(wrong, problem)[0], 0.5).verdict is Verdict.REFUTED
    assert judge_weak(weak_order(local_weak(*pair)), 1.0).verdict is Verdict.REFUTED


@pytest.mark.long
def test_each_interval_is_judged_by_its_own_steps() -> None:
    """What is lost after the second delay leaves the orders on the first two intervals what they are."""
    wrong, problem = LateLag(), delay_test("II", horizon=4.0)
    spans = (FIRST, SECOND, WHOLE)
    pairs = (remove_delay(wrong, problem, span.links, span.until) for span in spans)
    orders = [probed(*pair)[0] for pair in pairs]

    assert [judge_strong(order, 0.5).verdict.value for order in orders] == ["verified", "verified", "refuted"]


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "problem"), [(KnowsHistory(), delay_test("II")), (KnowsHistory(), delay_linear())]
)
def test_a_scheme_may_know_the_history(scheme: Scheme, problem: DelaySDAE) -> None:
    """Its steps are those of the theta method wherever a run can come: moments, constraint and local order agree."""
    right = StochasticTheta(0.0)
    record, expected = (delay_moment_errors(each, problem, STEPS) for each in (scheme, right))

    assert why_not_delay_moments(scheme, problem, STEPS) == ""
    np.testing.assert_array_equal(record.second, expected.second)
    assert least_order(moment_orders(record)) == pytest.approx((1.0, 1.0), abs=0.02)
    assert keeps_constraint(scheme, problem) is bool(problem.constraints)
    assert judge_weak(weak_order(local_weak(*remove_delay(scheme, problem))), 1.0).verdict is Verdict.VERIFIED


@pytest.mark.long
def test_moments_say_nothing_of_steps_that_change() -> None:
    """One matrix is not that of all steps where the lag is lost late, or where the history is read wrong."""
    problem, h = delay_test("II", horizon=4.0), 0.25

    assert why_not_lasting_step(LateLag(), problem, h) == DIFFERENT
    assert why_not_lasting_step(KnowsHistory(off=0.1), problem, h) == ""
    assert why_not_lasting_run(KnowsHistory(off=0.1), problem, h) == DIFFERENT
    assert (
        why_not_delay_moments(LateLag(), problem, STEPS) == why_not_delay_stability(LateLag(), problem) == DIFFERENT
    )
    assert not any("moments" in name for name in probe_weak(LateLag(), problem, Settings()).sums)
