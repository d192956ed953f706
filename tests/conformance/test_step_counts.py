"""A step that depends on the number of steps of its run is seen, although all levels of a run have N 2^k steps."""

from typing import ClassVar

import pytest

from cells import Formula
from facade import StochasticTheta, gbm, ou, violation
from measures.test_taken_back import InTurns
from sdaeverify import Claim
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


@pytest.mark.parametrize(("scheme", "rate"), [(Formula(euler, CLAIMS), 1.0), (StochasticTheta(), 400.0)])
def test_a_right_step_is_not_refuted(scheme, rate) -> None:
    """The same step for all sizes, also of an implicit scheme on a stiff equation."""
    assert not violation(scheme, ou(a=rate))
