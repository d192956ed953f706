"""A solver with draws its own random numbers does not apply: it is told what to do, and never refuted."""

from typing import ClassVar

import numpy as np
import pytest

from facade import EulerMaruyama, Trial, draws_own_numbers, gbm, ou, uses_declared_noise
from sdaeverify import SDE, Claim, Scheme, Step, verify

RNG = np.random.Generator(np.random.Philox(key=1))


class OwnNumbers(Scheme):
    """Euler-Maruyama that draws its noise, as a library does that knows of no other."""

    name: ClassVar[str] = "own-numbers"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, source="made up"),
        Claim(measure="invariant", value=1.0, source="made up"),
    )

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        drawn = np.sqrt(h) * RNG.standard_normal(noise.dW.shape)
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, drawn))


class AndGiven(OwnNumbers):
    """The same that uses the noise it is given, and evaluates the drift at a random time between."""

    name: ClassVar[str] = "and-given"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        when = t + h * RNG.uniform(size=state.shape[1:])
        drift = problem.drift(t, state) * (1.0 + when - t)
        return Step(state + h * drift + problem.diffused(t, state, noise.dW))


class Counting(OwnNumbers):
    """One that counts its calls: every other step is another one."""

    name: ClassVar[str] = "counting"
    calls: ClassVar[list[int]] = []

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        self.calls.append(1)
        drift = problem.drift(t, state) * (1.0 + 0.1 * (len(self.calls) % 2))
        return Step(state + h * drift + problem.diffused(t, state, noise.dW))


@pytest.mark.parametrize("scheme", [OwnNumbers(), AndGiven()], ids=lambda each: each.name)
def test_a_solver_with_numbers_of_its_own_does_not_apply(scheme):
    """Nothing is refuted: no cell applies, and the reason says where numbers are to come from."""
    result = verify(scheme, ["ou", "gbm"], paths=256)

    assert result.verdicts.empty
    assert not result.not_applicable.empty
    claimed = result.not_applicable[result.not_applicable.measure.isin(["weak", "invariant"])]
    assert any("draws its own random numbers" in reason for reason in claimed.reason)
    assert any("noise.dW" in reason for reason in claimed.reason)
    assert "refuted" not in set(result.classes.verdict)


def test_a_step_that_counts_its_calls_is_refuted():
    """Paths that are alike go to the same place: that two calls differ is a broken contract."""
    assert set(verify(Counting(), "ou", "weak", paths=256).verdicts.verdict) == {"refuted"}


def test_right_schemes_draw_nothing():
    """No shipped step of the problem's noise is taken for one with numbers of its own."""
    assert draws_own_numbers(EulerMaruyama(), gbm()) == ""
    assert draws_own_numbers(Counting(), ou()) == ""
    assert draws_own_numbers(OwnNumbers(), ou()) != ""


def test_no_other_fault_is_named():
    """A step that gives two results for one call is not told to use noise that it does not declare."""
    trial = Trial(OwnNumbers(), ou(), 0.1, np.ones((1, 8)), 8)

    assert uses_declared_noise(trial) == ""
