"""Findings on one scheme and one problem, held against each other: what tends elsewhere in one does so in others.

A scheme whose law tends to a wrong limit has paths that do; its state does where one of its components does. So
nothing is verified of paths or laws that another finding of the same run shows to end elsewhere. A step that does not
follow the equation at some of the states is wrong for all of them, and for the stationary law.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

from ..arrays import Array
from ..contracts.finding import SAMPLED, Finding, Kind, Verdict
from ..contracts.scheme import AT_T
from ..errors import FAULTS
from ..forms import Problem
from ..measures.path_errors.errors import STATE
from ..verdicts.rules import Case, send
from .judging import CellResult
from .plan import Cell

PATHS, LAW = "paths", "law"
DEPARTS = "one step does not follow the equation"
# Orders of convergence are multiples of 1/2: errors of an order below this along paths do not fall.
LEAST_ORDER = 0.25


class WrongLimit(NamedTuple):
    """What a scheme is known to do elsewhere.

    Attributes
    ----------
    measure, quantity : str
        That have shown it.
    follows : str
        Whether the ``law`` is wrong or the ``paths`` alone.
    components : frozenset of str
        Of the state that are concerned.
    departs : bool
        Whether one step has shown it, decided or not: it does not follow the equation.
    """

    measure: str
    quantity: str
    follows: str
    components: frozenset[str]
    departs: bool = False

    def concerns(self, follows: str, quantity: str) -> bool:
        """Tell whether it holds against what is said of a quantity of a measure that follows paths or a law."""
        if follows == PATHS:
            return _component(quantity) in {STATE, *self.components}
        # As steps get shorter, stationary laws and laws at T need not tend to theirs together.
        return self.departs or (follows == LAW and self.follows == LAW)

    def __str__(self) -> str:
        return f"{self.quantity} ({self.measure})"


def agreeing(problem: Problem | None, results: Sequence[CellResult]) -> tuple[CellResult, ...]:
    """Return the results on a problem, of which none is verified in spite of another.

    Parameters
    ----------
    problem : Problem or None
        Whose observables tell which components they are of; None where nothing could be run.
    results : sequence of CellResult
        In any order.
    """
    if problem is None:
        return tuple(results)
    wrong: dict[str, list[WrongLimit]] = defaultdict(list)
    for result in results:
        wrong[result.cell.scheme.label] += _wrong_limits(problem, result)
    return tuple(_held(result, wrong.get(result.cell.scheme.label, [])) for result in results)


def _wrong_limits(problem: Problem, result: CellResult) -> Iterator[WrongLimit]:
    measure = result.cell.measure
    for finding in result.findings if measure.follows in {PATHS, LAW} else ():
        refuted = finding.verdict is Verdict.REFUTED
        departs = finding.reason.has(Kind.INCONSISTENT) and (refuted or Verdict.VERIFIED in finding.excluded)
        if departs or (refuted and (finding.reason.has(Kind.WRONG_LIMIT) or _stands(finding))):
            read = _concerned(problem, result.cell, finding.quantity)
            yield WrongLimit(measure.name, finding.quantity, measure.follows, read, departs)


def _stands(finding: Finding) -> bool:
    """Tell whether errors along paths do not fall: the interval of their order ends below that of any convergence."""
    return finding.tier == SAMPLED and finding.high < LEAST_ORDER


def _concerned(problem: Problem, cell: Cell, quantity: str) -> frozenset[str]:
    if cell.measure.follows == LAW:
        return components_of(problem, cell, quantity)
    return frozenset({_component(quantity)})


def _held(result: CellResult, wrong: Sequence[WrongLimit]) -> CellResult:
    follows = result.cell.measure.follows
    if not (wrong and follows):
        return result
    findings = tuple(_against(finding, follows, wrong) for finding in result.findings)
    return replace(result, findings=findings)


def _against(finding: Finding, follows: str, wrong: Sequence[WrongLimit]) -> Finding:
    seen = [each for each in wrong if each.concerns(follows, finding.quantity)]
    if not seen:
        return finding
    what = DEPARTS if all(each.departs for each in seen) else str(Kind.WRONG_LIMIT)
    return send(finding, Case(elsewhere=f"{what} in {', '.join(sorted({str(each) for each in seen}))}"))


def _component(quantity: str) -> str:
    """Return the component that a quantity along paths is of, such as ``x@T`` or ``x on the grid``."""
    return quantity.split(" ", 1)[0].removesuffix(AT_T)


def components_of(problem: Problem, cell: Cell, observable: str) -> frozenset[str]:
    """Return the components of a scheme's state that an observable reads; none where there is no such observable.

    Parameters
    ----------
    problem : Problem
    cell : Cell
        Of a scheme on this problem.
    observable : str
    """
    if observable not in problem.observables:
        return frozenset()
    scheme, seen, read = cell.scheme, cell.seen, set[str]()
    with suppress(*FAULTS):
        parts = scheme.parts(seen, scheme.start(seen, 1, problem.horizon))
        problem.observables[observable](problem.horizon, _Read(parts, read))
    return frozenset(read)


class _Read(Mapping[str, Array]):
    """Components, and which of them were asked for."""

    def __init__(self, parts: Mapping[str, Array], read: set[str]) -> None:
        self.parts, self.read = parts, read

    def __getitem__(self, name: str) -> Array:
        self.read.add(name)
        return self.parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)
