"""A scheme of several steps may begin with a step of lower order, and be wrong in nothing else."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from facade import exactness_violation, gbm, ou, violation
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, verify

pytestmark = pytest.mark.long


class Two(NamedTuple):
    """A state, the one before, the noise of the step between them, and how many steps were made."""

    x: Array
    before: Array
    kick: Array
    number: Array


@dataclass(frozen=True)
class TwoSteps(Scheme):
    """BDF2-Maruyama that takes the state before its first step for the first one, or something worse."""

    off: float = 0.0
    power: float = 1.0
    weight: float = 2.0 / 3.0
    period: int = 0

    name: ClassVar[str] = "two-steps"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=0.5, source="Buckwar & Winkler 2006"),)

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Two:
        """Return the start: the state before is the same, or farther off."""
        return Two(state, state - self.off * h**self.power, np.zeros_like(state), np.zeros_like(state[:1]))

    def parts(self, problem: SDE, state: Two) -> dict[str, Array]:
        """Return the last state."""
        return dict(problem.parts(state.x))

    def step(self, problem: SDE, state: Two, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the implicit equation is iterated to rounding."""
        kick, number = problem.diffused(t, state.x, noise.dW), state.number[0, 0]
        weight = 0.0 if self.period and number % self.period == 0 else self.weight
        y = known = (4.0 * state.x - state.before - state.kick) / 3.0 + kick
        for _ in range(40):
            y = known + weight * h * problem.drift(t + h, y)
        return Step(Two(y, state.x, kick, state.number + 1.0))


class Ambitious(TwoSteps):
    """The same with a claim that its start breaks."""

    name: ClassVar[str] = "ambitious-two-steps"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="made up"),)


@pytest.mark.parametrize("problem", [gbm(), ou()])
def test_a_first_step_of_lower_order_is_let_pass(problem: SDE) -> None:
    """An error of the size h that is made once costs no order up to 1."""
    assert violation(TwoSteps(), problem) == ""
    assert violation(TwoSteps(off=3.0), problem) == ""


@pytest.mark.parametrize(
    ("scheme", "equation"),
    [
        (TwoSteps(off=1.0, power=0.0), "dx = 0"),
        (TwoSteps(off=1.0, power=0.5), "dx = 0"),
        (TwoSteps(weight=0.66), "dx = c dt"),
        (TwoSteps(period=10), "dx = c dt"),
        (TwoSteps(period=100), "dx = c dt"),
    ],
    ids=["start off by 1", "start off by the root of h", "wrong drift", "forgotten drift", "rarely forgotten drift"],
)
def test_what_costs_an_order_or_lasts_is_refuted(scheme: Scheme, equation: str) -> None:
    """A start that is farther off, which is said, and later steps that are not exact."""
    text = exactness_violation(scheme)

    assert text.startswith(f"not exact on {equation}")
    assert ("so that enter sets a wrong memory" in text) == (equation == "dx = 0")


def test_a_claim_above_the_order_of_the_start_is_not_verified() -> None:
    """What is let pass at first is for the paths."""
    found = verify([TwoSteps(), Ambitious()], "ou", "strong,weak", paths=2048).verdicts.query("claim != ''")

    assert set(found.verdict[found.scheme == "two-steps"]) == {"verified"}
    assert set(found.verdict[found.scheme == "ambitious-two-steps"]) == {"refuted"}
