"""A step that treats paths by their number is seen before a run, whatever number the probes have."""

from typing import ClassVar

import numpy as np
import pytest

from cells import Formula
from facade import EulerMaruyama, gbm, ou, violation
from sdaeverify import SDE, Array, Claim, Increment, Step, verify
from sdaeverify.measuring import Verdict
from testing.test_scheme_checks import euler, exchanging, right_in_blocks_of_13

CLAIMS = (Claim(measure="strong", value=0.5, source="made up"),)


@pytest.mark.parametrize("rule", [exchanging, right_in_blocks_of_13])
@pytest.mark.parametrize("problem", [ou(), gbm()], ids=["ou", "gbm"])
def test_faults_of_other_batches_than_those_of_probes_break_the_contract(rule, problem) -> None:
    """Neither copies in a row nor multiples of the number of probed states hide that paths see each other."""
    assert "a path in a different batch gives a different result" in violation(Formula(rule, CLAIMS), problem)


def right_for_likes(problem, x, h, noise):
    """Double the drift if nearly all of many paths have states, or noise, of their own, as in a run."""
    distinct = min(np.unique(part).size for part in (x[0], noise.dW[0])) > 0.9 * x.shape[1] > 20
    return euler(problem, x, h, noise) + h * problem.drift(0.0, x) * distinct


class RightButFor100(EulerMaruyama):
    """Euler-Maruyama, with twice the drift in batches of 100 paths."""

    name: ClassVar[str] = "right-but-for-100"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        times = 1.0 + (state.shape[1] == 100)
        return Step(state + times * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@pytest.mark.parametrize("problem", [ou(), gbm()], ids=["ou", "gbm"])
def test_a_fault_among_different_paths_breaks_the_contract(problem) -> None:
    """Copies of a few probed states with a few noises are no batch of a run."""
    found = violation(Formula(right_for_likes, CLAIMS), problem)
    assert "a path in a different batch gives a different result" in found


def test_a_fault_in_blocks_of_one_size_is_an_error_of_the_run() -> None:
    """Half of the paths of a block are stepped alone, whatever the size of the block."""
    table = verify([RightButFor100()], "ou", "strong", paths=400, block=100).verdicts

    assert set(table[table.scheme == RightButFor100.name].verdict) == {Verdict.ERROR}
    assert "a step of half of the paths gives another result" in str(table.reason.iloc[0]).lower()


def test_right_step_keeps_the_contract() -> None:
    """Euler's scheme breaks no contract in batches of any size."""
    assert not violation(Formula(euler, CLAIMS), ou())
