"""The smallest cover of all claims: each on one problem, the cheapest that can decide it.

Of the problems where a claim is in scope one is taken that has a pathwise truth, if there is any: all others cost a
run at much finer steps. Of those, one on which the claim counts, because no stronger claim of the scheme covers the
same quantity there; then the one with the fewest components; then the one with the most kinds of exact solutions;
then the first by its label. So the choice depends on nothing that was measured, and changes only with the problems
and the claims themselves. A claim that counts only where there is no such truth is left to the larger tiers.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ..contracts.matching import match
from ..contracts.scheme import Claim, Scheme
from ..errors import FAULTS
from ..forms import components
from ..measures.judge import claim_for
from ..study import Cell, ProblemPlan
from ..study.claimed import claims_of

Rank = tuple[bool, bool, int, int, str]


class _Test(NamedTuple):
    """A claim that a cell puts to the test, and the rank of its problem."""

    scheme: Scheme
    claim: Claim
    rank: Rank
    cell: Cell


def every_claim_once(plans: Sequence[ProblemPlan]) -> list[ProblemPlan]:
    """Keep, for each claim of each scheme, the cell on one problem.

    Parameters
    ----------
    plans : sequence of ProblemPlan
        With their claimed cells.

    Returns
    -------
    list of ProblemPlan
        The same problems with the cells that are kept, and with all that are in error as they stand: whether a claim
        holds there cannot be told.
    """
    best: dict[tuple[Scheme, Claim], _Test] = {}
    for test in (test for made in plans for test in _tests(made)):
        known = best.setdefault((test.scheme, test.claim), test)
        if test.rank < known.rank:
            best[test.scheme, test.claim] = test
    kept = {id(test.cell) for test in best.values()}
    return [replace(made, cells=tuple(_kept(made.cells, kept))) for made in plans]


def size(problem: Any) -> int:
    """Return the number of components of a problem; 0 where there is none, or none that has a start."""
    try:
        return components(problem) if problem else 0
    except FAULTS:
        # What is wrong with a plugin's problem shows in its cells.
        return 0


def _tests(made: ProblemPlan) -> Iterator[_Test]:
    problem = made.problem
    if problem is None:
        return
    kinds = {type(truth) for truth in problem.truths}
    ends = size(problem), -len(kinds), made.spec.label
    for cell in made.cells:
        view = match(cell.scheme, problem).problem if cell.verdict is None else None
        for claim in claims_of(cell, problem) if view else ():
            rank = (problem.pathwise is None, not _counts(claim, cell.scheme, view), *ends)
            yield _Test(cell.scheme, claim, rank, cell)


def _counts(claim: Claim, scheme: Scheme, view: Any) -> bool:
    quantities = claim.quantities or ("",)
    return any(claim_for(scheme, view.traits, claim.measure, name)[0] is claim for name in quantities)


def _kept(cells: Iterable[Cell], kept: set[int]) -> Iterator[Cell]:
    return (cell for cell in cells if cell.verdict is not None or id(cell) in kept)
