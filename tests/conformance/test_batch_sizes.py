"""A step that treats paths by their number is seen before a run, whatever number the probes have."""

import pytest

from cells import Formula
from facade import gbm, ou, violation
from sdaeverify import Claim
from testing.test_scheme_checks import euler, exchanging, right_in_blocks_of_13

CLAIMS = (Claim(measure="strong", value=0.5, source="made up"),)


@pytest.mark.parametrize("rule", [exchanging, right_in_blocks_of_13])
@pytest.mark.parametrize("problem", [ou(), gbm()], ids=["ou", "gbm"])
def test_faults_of_other_batches_than_those_of_probes_break_the_contract(rule, problem) -> None:
    """Neither copies in a row nor multiples of the number of probed states hide that paths see each other."""
    assert "a path in a different batch gives a different result" in violation(Formula(rule, CLAIMS), problem)


def test_right_step_keeps_the_contract() -> None:
    """Euler's scheme breaks no contract in batches of any size."""
    assert not violation(Formula(euler, CLAIMS), ou())
