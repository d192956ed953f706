"""Which cells of a plan a claim is put to the test in."""

from ..contracts.matching import match
from ..contracts.measure import Verdict
from ..contracts.scheme import Claim
from ..forms import Problem
from .plan import Cell


def promises_of(cell: Cell) -> tuple[Claim, ...]:
    """Return the claims of a cell's scheme that name its measure, in scope or not."""
    return tuple(claim for claim in cell.scheme.promises if claim.measure == cell.measure.name)


def claims_of(cell: Cell, problem: Problem | None) -> tuple[Claim, ...]:
    """Return the claims that a cell puts to the test: all that might be, where what is wrong hides the scope.

    Parameters
    ----------
    cell : Cell
    problem : Problem or None
        That of the cell; None if it could not be built.
    """
    promised = promises_of(cell)
    if cell.verdict is Verdict.NOT_APPLICABLE or not promised:
        return ()
    if cell.verdict is not None or problem is None:
        return promised
    view = match(cell.scheme, problem).problem
    return tuple(claim for claim in promised if view is not None and claim.when <= view.traits)
