"""A step that depends on the number of steps of its run is seen, although all levels of a run have N 2^k steps."""

from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from cells import Formula
from facade import StochasticTheta, double_well, gbm, ou, violation
from measures.test_taken_back import InTurns
from sdaeverify import SDE, Array, Claim, Increment, Parts, Scheme, Step
from testing.test_scheme_checks import euler, right_for_powers_of_two

CLAIMS = (Claim(measure="strong", value=0.5, source="made up"),)


@pytest.mark.parametrize("problem", [ou(), gbm()], ids=["ou", "gbm"])
def test_a_step_that_is_right_for_powers_of_two_is_refuted(problem) -> None:
    """Its errors are those of all levels and probes, and of no other run."""
    assert "depends on the number of steps" in violation(Formula(right_for_powers_of_two, CLAIMS), problem)


class SaysInTurns(Formula):
    """A formula whose steps are said to be of several kinds in turn."""

    local_order_is_global: ClassVar[bool] = False


def test_a_declaration_of_steps_in_turns_excuses_nothing() -> None:
    """Steps before which as many steps were made are of the same kind, so that their sizes are still compared."""
    wrong = SaysInTurns(right_for_powers_of_two, CLAIMS)
    assert "depends on the number of steps" in violation(wrong, ou())
    assert not violation(InTurns(), ou())


class Counted(NamedTuple):
    """A state and the number of steps before it."""

    x: Array
    count: Array


class CountedTurns(Scheme):
    """Euler's drift in steps of even number and Heun's in the others, either of them of the claimed order."""

    name: ClassVar[str] = "counted-turns"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = CLAIMS

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Counted:
        """Return the state with the number of steps that lead to it."""
        return Counted(state, np.full((1, state.shape[1]), np.rint(t / h)))

    def parts(self, problem: SDE, state: Counted) -> Parts:
        """Return x."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Counted, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f, kick = state.x, problem.drift(t, state.x), problem.diffused(t, state.x, noise.dW)
        heun = 0.5 * (f + problem.drift(t + h, x + h * f + kick))
        return Step(Counted(x + h * np.where(state.count % 2 == 0, f, heun) + kick, state.count + 1))


def test_steps_in_turns_of_the_same_order_are_not_refuted() -> None:
    """Steps of different sizes are compared at the same number of steps from the start, without a declaration."""
    assert not violation(CountedTurns(), double_well())


@pytest.mark.parametrize(("scheme", "rate"), [(Formula(euler, CLAIMS), 1.0), (StochasticTheta(), 400.0)])
def test_a_right_step_is_not_refuted(scheme, rate) -> None:
    """The same step for all sizes, also of an implicit scheme on a stiff equation."""
    assert not violation(scheme, ou(a=rate))
