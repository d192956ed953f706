"""Expected failures: findings that are known not to pass, each with its reason."""

from collections.abc import Iterable
from dataclasses import dataclass

from ..contracts.finding import Finding
from ..contracts.labels import matches
from ..errors import UsageError, is_blank
from ..study import Cell


@dataclass(frozen=True, kw_only=True)
class ExpectedFailure:
    """A pattern of findings that are expected to fail.

    A step that raises, hangs, dies or breaks its contract fails all the same.

    Attributes
    ----------
    reason : str
        Why; it is shown with every finding that matches.
    scheme, problem, measure, quantity : str
        Globs of labels and names, in which ``*`` and ``?`` alone are special.
    strict : bool
        Whether a finding that matches fails the gate once it is verified.

    Raises
    ------
    UsageError
        If there is no reason.
    """

    reason: str
    scheme: str = "*"
    problem: str = "*"
    measure: str = "*"
    quantity: str = "*"
    strict: bool = True

    def __post_init__(self) -> None:
        if is_blank(self.reason):
            raise UsageError(f"the expected failure {self} has no reason; say why it is expected")

    def matches(self, cell: Cell, finding: Finding) -> bool:
        """Tell whether a finding is meant."""
        pairs = (
            (self.scheme, cell.scheme.label),
            (self.problem, cell.spec.label),
            (self.measure, cell.measure.name),
            (self.quantity, finding.quantity),
        )
        return all(matches(glob, text) for glob, text in pairs)

    def __str__(self) -> str:
        named = ("scheme", "problem", "measure", "quantity")
        given = [f"{name}={getattr(self, name)}" for name in named if getattr(self, name) != "*"]
        return ", ".join(given) or "everything"


def expectation(cell: Cell, finding: Finding, expected: Iterable[ExpectedFailure]) -> ExpectedFailure | None:
    """Return the first expected failure that a finding matches, or None.

    Parameters
    ----------
    cell : Cell
    finding : Finding
        Of one quantity in the cell.
    expected : iterable of ExpectedFailure
        Those of the policy, in its order.
    """
    return next((one for one in expected if one.matches(cell, finding)), None)
