"""Whether a state is all memory: a scheme of two steps that carries its drift passes, one that hides it does not."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from facade import StochasticTheta, Trial, carries_its_memory, delay_ou, double_well
from sdaeverify import SDE, Array, Scheme, Step
from sdaeverify.numerics import apply


class Remembered(NamedTuple):
    x: Array
    f: Array


@dataclass(frozen=True)
class TwoSteps(Scheme):
    """Adams-Bashforth with the last drift in its state."""

    name: ClassVar[str] = "two-steps"
    form: ClassVar[type] = SDE

    def enter(self, problem, state, t, h):
        return Remembered(state, problem.drift(t, state))

    def parts(self, problem, state):
        return problem.parts(state.x)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        f = problem.drift(t, state.x)
        new = state.x + h * (1.5 * f - 0.5 * state.f) + apply(problem.diffusion(t, state.x), noise.dW)
        return Step(Remembered(new, f))


class Noted(np.ndarray):
    """An array with a note that a copy of its numbers has not."""


@dataclass(frozen=True)
class Annotating(TwoSteps):
    """The same with the drift in a note on the array."""

    def enter(self, problem, state, t, h):
        return state

    def parts(self, problem, state):
        return problem.parts(state)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        x = np.asarray(state)
        f = problem.drift(t, x)
        new = (x + h * f + apply(problem.diffusion(t, x), noise.dW)).view(Noted)
        new.steps = getattr(state, "steps", 0) + 1
        return Step(new)


@dataclass(frozen=True)
class Clocked(TwoSteps):
    """The same, whose instance counts its steps and makes every fourth one longer."""

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        made = self.__dict__.get("made", 0) + 1
        object.__setattr__(self, "made", made)
        return super().step(problem, state, t, h if made % 4 else 1.01 * h, noise)


def trial(scheme, problem):
    return Trial(scheme, problem, problem.horizon / 8, None, 4)


@pytest.mark.parametrize("scheme", [TwoSteps(), Annotating()])
def test_memory_in_the_state_is_found_there(scheme):
    """What is in the arrays of the state goes on with them; a note that changes nothing does no harm."""
    assert carries_its_memory(trial(scheme, double_well())) == ""


def test_a_delay_is_memory_of_the_run():
    """Lagged values come with the noise: they are no memory of the scheme."""
    assert carries_its_memory(trial(StochasticTheta(0.5), delay_ou())) == ""


def test_an_instance_that_counts_is_found():
    """A fresh scheme counts from the beginning, and its run ends elsewhere."""
    assert "the scheme remembers more than its state" in carries_its_memory(trial(Clocked(), double_well()))
