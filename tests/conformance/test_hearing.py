"""Whether a step hears its noise: only where the equation has some, and a step is made."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import StochasticTheta, Trial, delay_martingale, gbm, hears_its_noise, keeps_no_noise
from sdaeverify import SDE, THREE_POINT, Law, Scheme, Step
from sdaeverify.numerics import apply


@dataclass(frozen=True)
class Euler(Scheme):
    """Euler's scheme, which may refuse half of the paths, or take no noise."""

    share: float = 0.0
    strength: float = 1.0

    name: ClassVar[str] = "euler"
    form: ClassVar[type] = SDE

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        failed = np.arange(state.shape[1]) < self.share * state.shape[1]
        kick = self.strength * apply(problem.diffusion(t, state), noise.dW)
        new = state + h * problem.drift(t, state) + kick
        return Step(np.where(failed, state, new), failed=failed)


@dataclass(frozen=True)
class Bounded(Euler):
    """The same with bounded increments, of which two thirds vanish."""

    law: ClassVar[Law] = THREE_POINT


@dataclass(frozen=True)
class Rejecting(Euler):
    """The same that rejects on half of the paths, and says that it jumps."""

    jumps: ClassVar[bool] = True

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        made = super().step(problem, state, t, h, noise).state
        return Step(np.where(np.arange(state.shape[1]) % 2, made, state))


@dataclass(frozen=True)
class Silent(Rejecting):
    """The same that does not say it."""

    jumps: ClassVar[bool] = False


def trial(scheme, problem):
    return Trial(scheme, problem, problem.horizon / 8, None, 12)


@pytest.mark.parametrize("scheme", [Euler(), Euler(share=0.5), Bounded(), Rejecting()])
def test_paths_that_cannot_hear_are_not_counted(scheme):
    """A step that fails stays where it was, and an increment of zero has no sign."""
    assert hears_its_noise(trial(scheme, gbm())) == ""


@pytest.mark.parametrize("scheme", [Euler(strength=0.0), Bounded(strength=0.0), Silent(), Rejecting(strength=0.0)])
def test_a_deaf_scheme_is_found(scheme):
    """Without noise nothing changes on any path that the equation moves."""
    assert "changes nothing on" in hears_its_noise(trial(scheme, gbm()))


def test_a_delayed_noise_is_heard():
    """With a delay the noise of the equation is that of the lagged state."""
    assert hears_its_noise(trial(StochasticTheta(0.5), delay_martingale())) == ""


def test_a_state_of_its_own_keeps_no_noise():
    """A sum is a new array."""
    assert keeps_no_noise(trial(Euler(), gbm())) == ""
