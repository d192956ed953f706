"""The conformance kit on a form with jumps."""

from sdaeverify_jumps.geometric_jumps import geometric_jumps
from sdaeverify_jumps.jump_euler import JumpEuler
from sdaeverify_jumps.shot_noise import shot_noise

from sdaeverify.testing import parametrize_with_checks


@parametrize_with_checks([JumpEuler(), geometric_jumps, shot_noise], problems=[geometric_jumps, shot_noise])
def test_contract(subject, check):
    """Scheme and problems pass the conformance kit."""
    check(subject)
