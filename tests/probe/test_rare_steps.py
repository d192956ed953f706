"""Steps that are wrong at some indices only, late, after many calls or by what the state remembers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from facade import (
    DIFFERENT,
    EulerMaruyama,
    double_well,
    forced_ou,
    judge_strong,
    judge_weak,
    local_strong,
    local_weak,
    odd_step,
    ou,
    strong_orders,
    weak_order,
)
from sdaeverify import SDE, Array, Increment, Step
from sdaeverify.measuring import Verdict
from sdaeverify.probe.step.states import cloud, reached_states
from sdaeverify.probing import OneStep, why_not_moments, why_not_operator

WELL, FORCED = double_well(), forced_ou()
# Whether a step n of size h at time t of a run up to T is wrong.
When = Callable[[int, float, float, float], bool]


@dataclass(frozen=True)
class Sometimes(EulerMaruyama):
    """Euler-Maruyama without drift in some steps."""

    when: When = lambda n, t, h, T: False

    name: ClassVar[str] = "sometimes"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        drift = 0.0 if self.when(round(t / h), t, h, problem.horizon) else problem.drift(t, state)
        return Step(state + h * drift + problem.diffused(t, state, noise.dW))


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("right", "problem"),
    [
        (lambda n, t, h, T: False, FORCED),
        (lambda n, t, h, T: n < 3, WELL),
        (lambda n, t, h, T: n < 3, FORCED),
        (lambda n, t, h, T: t + 1.5 * h > T, WELL),
        (lambda n, t, h, T: t + 1.5 * h > T, FORCED),
    ],
    ids=["never", "a start", "a start, moving", "the last step", "the last step, moving"],
)
def test_single_steps_cost_no_order(right: When, problem: SDE) -> None:
    """A first or last step with an error of its own size h leaves the scheme its order 1."""
    scheme = Sometimes(right)

    assert odd_step(OneStep(scheme, problem)) is None
    assert judge_strong(strong_orders(local_strong(scheme, problem))[-1], 1.0).verdict is Verdict.VERIFIED
    assert judge_weak(weak_order(local_weak(scheme, problem)), 1.0).verdict is Verdict.VERIFIED


@pytest.mark.parametrize(
    "wrong",
    [lambda n, t, h, T: n % 16 == 0, lambda n, t, h, T: n % 100 == 0, lambda n, t, h, T: t > 0.9 * T],
    ids=["every 16", "every 100", "the last tenth"],
)
def test_one_step_s_moments_or_law_are_not_those_of_all(wrong: When) -> None:
    """Neither moments nor the transition operator speak for a scheme whose steps differ."""
    scheme = Sometimes(wrong)

    assert why_not_moments(EulerMaruyama(), ou()) == why_not_operator(EulerMaruyama(), WELL) == ""
    assert why_not_moments(scheme, ou()) == why_not_operator(scheme, WELL) == DIFFERENT


@dataclass(frozen=True)
class SometimesSomewhere(EulerMaruyama):
    """Euler-Maruyama without drift in some steps from states in an interval."""

    when: When = lambda n, t, h, T: False
    low: float = 0.0
    high: float = 0.0

    name: ClassVar[str] = "sometimes-somewhere"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        inside = (state > self.low) & (state < self.high)
        wrong = self.when(round(t / h), t, h, problem.horizon) & inside
        drift = np.where(wrong, 0.0, problem.drift(t, state))
        return Step(state + h * drift + problem.diffused(t, state, noise.dW))


@pytest.mark.sweep
@pytest.mark.parametrize(
    "when",
    [
        lambda n, t, h, T: 0.32 < (t + 0.5 * h) / T < 0.53,
        lambda n, t, h, T: n % 6 == 5,
    ],
    ids=["in a window", "every sixth"],
)
@pytest.mark.parametrize("problem", [WELL, FORCED], ids=["autonomous", "moving"])
def test_steps_that_are_wrong_in_a_region_at_some_times_are_refuted(when: When, problem: SDE) -> None:
    """Times are looked for at the states that runs reach: none of the cloud is in the interval."""
    places = np.sort(cloud(problem, problem)[0])
    often = int(np.histogram(reached_states(problem, problem).points, places)[0].argmax())
    scheme = SometimesSomewhere(when, *places[often : often + 2].tolist())

    assert judge_weak(weak_order(local_weak(scheme, problem)), 1.0).verdict is not Verdict.VERIFIED
    assert judge_strong(strong_orders(local_strong(scheme, problem))[-1], 0.5).verdict is not Verdict.VERIFIED


class Counted(NamedTuple):
    x: Array
    n: Array


@dataclass(frozen=True)
class CountsSteps(EulerMaruyama):
    """The number of steps is a component of the state, set by `enter` or not."""

    entered: bool = False
    period: int = 16

    name: ClassVar[str] = "counts-steps"

    def enter(self, problem: Any, state: Any, t: float, h: float) -> Counted:
        return Counted(state, np.full((1, state.shape[-1]), float(round(t / h)) if self.entered else 0.0))

    def parts(self, problem: Any, state: Counted) -> dict[str, Array]:
        return {"x": state.x}

    def step(self, problem: SDE, state: Any, t: float, h: float, noise: Increment) -> Step:
        x, n = state
        drift = np.where(n % self.period == self.period - 1, 0.0, problem.drift(t, x))
        return Step(Counted(x + h * drift + problem.diffused(t, x, noise.dW), n + 1.0))


@pytest.mark.sweep
@pytest.mark.parametrize("period", [7, 16, 100])
def test_a_run_that_remembers_its_length_has_no_one_step_map(period: int) -> None:
    """Where it cannot, nothing is said of the scheme by single steps, and paths alone judge it."""
    assert "steps of a run differ" in OneStep(CountsSteps(period=period), WELL).why_not_probed()
    assert OneStep(CountsSteps(period=10**6), WELL).why_not_probed() == ""
