"""Whether memory of a run takes it elsewhere than the same state entered anew, however short steps are."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from averaged_noise import LeimkuhlerMatthews
from facade import (
    ExplicitProjectionEuler,
    StochasticTheta,
    departure,
    double_well,
    gbm,
    gbm_algebraic,
    match,
    ou,
    pendulum,
)
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step
from sdaeverify.probe.local.run_memory import Apart, run_memory
from sdaeverify_lab.planted.states import UnsolvedTheta

CLAIMS = tuple(Claim(measure=name, value=value, source="made up") for name, value in (("strong", 0.5), ("weak", 1.0)))


class Remembered(NamedTuple):
    x: Array
    memory: Array


class Remembering(Scheme):
    """Base of schemes with one array beside the state."""

    form: ClassVar[type] = SDE
    claims: ClassVar = CLAIMS

    def enter(self, problem: Any, state: Array, t: float, h: float) -> Remembered:
        return Remembered(state, problem.drift(t, state) + 0.0 * state)

    def parts(self, problem: Any, state: Remembered) -> Any:
        return problem.parts(state.x)


@dataclass(frozen=True)
class AdamsBashforth(Remembering):
    """Two steps of the drift, the older one of which is not renewed far out."""

    bound: float = np.inf

    name: ClassVar[str] = "adams-bashforth"

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        x, old = state
        f = problem.drift(t, x)
        new = x + h * (1.5 * f - 0.5 * old) + problem.diffused(t, x, noise.dW)
        return Step(Remembered(new, np.where(np.abs(x) > self.bound, old, f)))


@dataclass(frozen=True)
class Tired(Remembering):
    """Euler-Maruyama that loses its drift after so many steps, which it counts in its memory."""

    after: int = 130

    name: ClassVar[str] = "tired"

    def enter(self, problem: Any, state: Array, t: float, h: float) -> Remembered:
        return Remembered(state, np.zeros((1, state.shape[-1])))

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        drift = np.where(state.memory < self.after, problem.drift(t, state.x), 0.0)
        new = state.x + h * drift + problem.diffused(t, state.x, noise.dW)
        return Step(Remembered(new, state.memory + 1.0))


WRONG = {
    "a drift that is not renewed": (AdamsBashforth(1.3), double_well()),
    "a counter": (Tired(), double_well()),
    "an algebraic component": (UnsolvedTheta(), gbm_algebraic()),
}
RIGHT = {
    "two drifts": (AdamsBashforth(), double_well()),
    "two drifts of a long run": (AdamsBashforth(), ou(horizon=16.0)),
    "an increment": (LeimkuhlerMatthews(), double_well()),
    "a counter that does nothing": (Tired(10**6), gbm()),
    "an algebraic component": (StochasticTheta(), gbm_algebraic()),
    "projections that are rarer than a part of the run": (ExplicitProjectionEuler(skip=20), pendulum()),
}


def seen(scheme: Scheme, problem: Any) -> Any:
    view = match(scheme, problem).problem
    assert view is not None
    return view


@pytest.mark.long
@pytest.mark.parametrize("name", WRONG)
def test_memory_that_goes_wrong_in_a_run_is_told(name: str) -> None:
    """What `enter` would set right and a run does not is found where pilot paths go, at all times."""
    scheme, problem = WRONG[name]
    assert "a run and a restart by enter(problem, state, t, h) differ" in departure(scheme, seen(scheme, problem))


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("name", RIGHT)
def test_memory_that_is_right_is_let_pass(name: str) -> None:
    """Old drifts, halves of increments and counters differ from what `enter` sets by what vanishes with h."""
    scheme, problem = RIGHT[name]
    assert run_memory(scheme, seen(scheme, problem)) is not None
    assert departure(scheme, seen(scheme, problem)) == ""


class Unentered(AdamsBashforth):
    """The same, whose memory the first step alone can set."""

    name: ClassVar[str] = "unentered"

    def enter(self, problem: Any, state: Array, t: float, h: float) -> Any:
        return state

    def start(self, problem: Any, paths: int, h: float) -> Remembered:
        x = problem.initial(paths)
        return Remembered(x, problem.drift(0.0, x) + 0.0 * x)


def test_memory_that_cannot_be_entered_is_not_compared() -> None:
    """Nothing is said of it, and nothing is raised."""
    assert run_memory(Unentered(), double_well()) is None
    assert departure(Unentered(), double_well()) == ""


@pytest.mark.parametrize("delayed", [False, True])
def test_a_scheme_with_a_history_of_its_own_is_told_what_to_override(delayed: bool) -> None:
    """With a delay the memory may be a history; without one `enter` can set it."""
    stays = (np.array([[0.2]]), np.array([[0.2]]))
    departure = Apart(("x",), stays, delayed).departure
    assert departure.endswith("whatever h") is not delayed
    assert departure.endswith("overrides start(problem, paths, h) instead of enter") is delayed
