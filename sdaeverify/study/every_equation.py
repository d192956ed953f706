"""The placeholder of a class of equations in the place of a problem, and what findings on it have in common."""

from ..contracts.finding import CONDITIONS, Finding, Verdict
from ..errors import UsageError
from ..forms import Problem

# Label of the equations of a class in the column of problems.
EVERY_EQUATION = "every-equation"
# Kinds of tests of a claim about a class: the quantity of their findings.
ORDER_CONDITIONS, RANDOM_MEMBERS = "order conditions", "random members"


def every_equation(of: str = "general") -> Problem:
    """Represent all equations of a class in the specification of a cell; there is no problem to be built.

    Parameters
    ----------
    of : str
        Name of the class.

    Raises
    ------
    UsageError
        Always.
    """
    raise UsageError(f"a class of equations is not a problem: {of!r:.200} cannot be built")


def is_premise_failing(finding: Finding) -> bool:
    """Return whether a premise of the conditions fails, so that the claim is tested by paths alone."""
    return finding.tier == CONDITIONS and finding.verdict is Verdict.INCONCLUSIVE
