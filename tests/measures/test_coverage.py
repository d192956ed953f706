"""Why a scheme claims nothing of a quantity on a problem."""

from facade import ConstrainedEuler, affine_constraint, claim_for
from sdaeverify import verify


def test_a_gap_names_the_traits_that_the_problem_lacks():
    """A stiff penalty is no constraint, whatever the problem is called: claims for constraints do not cover it."""
    rows = verify([ConstrainedEuler()], [affine_constraint], "strong", paths=100, levels=3).verdicts

    assert set(rows.verdict) == {"out_of_scope"}
    gap = "No claim about x here: claims of the scheme need the trait constrained, which this problem lacks."
    assert rows.reason[0] == gap


def test_what_nobody_claims_is_no_question_of_traits():
    """Where no claim is about a quantity on any problem, none is named."""
    assert str(claim_for(ConstrainedEuler(), (), "stability", "second moment").gap) == "no claim about second moment"
