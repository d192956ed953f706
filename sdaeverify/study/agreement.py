"""Consistency of findings on one scheme and one problem: a wrong limit in one finding affects the related ones.

If the law of a scheme tends to a wrong limit, so do its paths; if a component of its state does, so does the state.
So no claim about paths or laws is verified if another finding of the same run shows a wrong limit. A step that does
not follow the equation at some of the states is wrong for all of them, and for the stationary law.
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
# Orders of convergence are multiples of 1/2, so errors along paths with an order below this do not converge.
LEAST_ORDER = 0.25


class WrongLimit(NamedTuple):
    """A quantity of a scheme that tends to a wrong limit.

    Attributes
    ----------
    measure, quantity : str
        The measure and the quantity of its finding.
    follows : str
        ``law`` if the law is wrong, ``paths`` if only the paths are.
    components : frozenset of str
        Affected components of the state.
    departs : bool
        Whether the evidence, decided or not, is that one step does not follow the equation.
    """

    measure: str
    quantity: str
    follows: str
    components: frozenset[str]
    departs: bool = False

    def concerns(self, follows: str, quantity: str) -> bool:
        """Return whether the wrong limit contradicts a claim about a quantity; `follows` is that of the measure."""
        if follows == PATHS:
            return _component(quantity) in {STATE, *self.components}
        # As steps get shorter, stationary laws and laws at T may converge independently of each other.
        return self.departs or (follows == LAW and self.follows == LAW)

    def __str__(self) -> str:
        return f"{self.quantity} ({self.measure})"


def agreeing(problem: Problem | None, results: Sequence[CellResult]) -> tuple[CellResult, ...]:
    """Return the results on a problem, with verified findings revised that another finding contradicts.

    Parameters
    ----------
    problem : Problem or None
        Its observables are evaluated to find the components they depend on; None if it could not be built.
    results : sequence of CellResult
        In any order.
    """
    if problem is None:
        return tuple(results)
    wrong: dict[str, list[WrongLimit]] = defaultdict(list)
    for result in results:
        wrong[result.cell.scheme.label] += _wrong_limits(problem, result)
    return tuple(_revise_result(result, wrong.get(result.cell.scheme.label, [])) for result in results)


def _wrong_limits(problem: Problem, result: CellResult) -> Iterator[WrongLimit]:
    measure = result.cell.measure
    for finding in result.findings if measure.follows in {PATHS, LAW} else ():
        refuted = finding.verdict is Verdict.REFUTED
        departs = finding.reason.has(Kind.INCONSISTENT) and (refuted or Verdict.VERIFIED in finding.excluded)
        if departs or (refuted and (finding.reason.has(Kind.WRONG_LIMIT) or _does_not_converge(finding))):
            read = _affected_components(problem, result.cell, finding.quantity)
            yield WrongLimit(measure.name, finding.quantity, measure.follows, read, departs)


def _does_not_converge(finding: Finding) -> bool:
    """Return whether errors along paths do not fall: the interval of their order ends below `LEAST_ORDER`."""
    return finding.tier == SAMPLED and finding.high < LEAST_ORDER


def _affected_components(problem: Problem, cell: Cell, quantity: str) -> frozenset[str]:
    if cell.measure.follows == LAW:
        return components_of(problem, cell, quantity)
    return frozenset({_component(quantity)})


def _revise_result(result: CellResult, wrong: Sequence[WrongLimit]) -> CellResult:
    follows = result.cell.measure.follows
    if not (wrong and follows):
        return result
    findings = tuple(_revise_finding(finding, follows, wrong) for finding in result.findings)
    return replace(result, findings=findings)


def _revise_finding(finding: Finding, follows: str, wrong: Sequence[WrongLimit]) -> Finding:
    seen = [each for each in wrong if each.concerns(follows, finding.quantity)]
    if not seen:
        return finding
    what = DEPARTS if all(each.departs for each in seen) else str(Kind.WRONG_LIMIT)
    return send(finding, Case(elsewhere=f"{what} in {', '.join(sorted({str(each) for each in seen}))}"))


def _component(quantity: str) -> str:
    """Return the component that a quantity along paths belongs to, such as ``x`` for ``x@T`` or ``x on the grid``."""
    return quantity.split(" ", 1)[0].removesuffix(AT_T)


def components_of(problem: Problem, cell: Cell, observable: str) -> frozenset[str]:
    """Return the components of a scheme's state that an observable reads; empty if the observable is unknown.

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
    """Mapping of components that records the names that are accessed."""

    def __init__(self, parts: Mapping[str, Array], read: set[str]) -> None:
        self.parts, self.read = parts, read

    def __getitem__(self, name: str) -> Array:
        self.read.add(name)
        return self.parts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)
