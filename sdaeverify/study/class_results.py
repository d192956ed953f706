"""Claims about classes of equations as results of cells, so that gates and tables can count them.

Each class is represented by a placeholder problem. These results are separate from the cells of a study.
"""

from collections.abc import Iterable, Iterator, Sequence

from ..contracts.finding import CONDITIONS, Finding, Kind, Method, Reason, Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..simulate.ensemble import Entry
from ..trees.class_row import EVERY_EQUATION, ClassRow
from ..trees.classes import tree_classes_of
from ..trees.report import MEASURES, claimed_measures, every_equation
from .class_rows import SEED, rows_on
from .judging import CellResult
from .members.classes import member_classes
from .order_report import classes_named
from .plan import Cell


def class_results(rows: Iterable[ClassRow], cells: Sequence[Cell]) -> Iterator[CellResult]:
    """Yield the verdicts of order conditions on the claims of schemes, as results of cells.

    Parameters
    ----------
    rows : iterable of ClassRow
    cells : sequence of Cell
        Of the run, with these schemes and measures.
    """
    schemes = {cell.scheme.label: cell.scheme for cell in cells}
    measures = {cell.measure.name: cell.measure for cell in cells}
    for row in rows:
        if row.measure in measures:
            cell = _class_cell(schemes[row.scheme], row.kind, measures[row.measure])
            yield CellResult(cell, (_finding(row),))


def is_premise_failing(finding: Finding) -> bool:
    """Return whether a premise of the conditions fails, so that the claim is tested by paths alone."""
    return finding.tier == CONDITIONS and finding.verdict is Verdict.INCONCLUSIVE


def class_cells(cells: Iterable[Cell], seed: int = SEED) -> Iterator[Cell]:
    """Yield a cell for each class that a scheme's claims are about, for the schemes and measures of the given cells.

    No step is made.

    Parameters
    ----------
    cells : iterable of Cell
    seed : int
        Of the run.
    """
    for scheme, measure in dict.fromkeys((cell.scheme, cell.measure) for cell in cells):
        for kind in tree_classes_of(scheme) if measure.name in MEASURES else ():
            if measure.name in claimed_measures(scheme, kind):
                yield _class_cell(scheme, kind.name, measure)
        for members, claims in member_classes(scheme, seed).items():
            if answers(measure) and measure.name in {claim.measure for claim in claims}:
                yield _class_cell(scheme, members.name, measure)


def answers(measure: Measure) -> bool:
    """Return whether a measure can judge random members."""
    return type(measure).judge_member is not Measure.judge_member


def results_of_class(cell: Cell, seed: int = SEED) -> list[CellResult]:
    """Return the results on the claim of a cell about a class, computed in this process.

    Parameters
    ----------
    cell : Cell
        One that `class_cells` yields.
    seed : int
        Of the run.
    """
    (kind,) = classes_named(cell.scheme, [class_of(cell)])
    return [*class_results(rows_on(Entry(cell.scheme, (cell.measure,)), kind, seed), [cell])]


def _class_cell(scheme: Scheme, kind: str, measure: Measure) -> Cell:
    return Cell(scheme, ProblemSpec(EVERY_EQUATION, every_equation, (("of", kind),)), measure)


def is_of_class(cell: Cell) -> bool:
    """Return whether a cell is about a class of equations."""
    return cell.spec.function is every_equation


def class_of(cell: Cell) -> str:
    """Return the name of the class that a cell is about."""
    return str(dict(cell.spec.parameters)["of"])


def _finding(row: ClassRow) -> Finding:
    return Finding(
        quantity="" if row.verdict is Verdict.ERROR else row.conditions,
        verdict=row.verdict,
        reason=Reason(row.why, Kind.NO_CLAIM if row.verdict is Verdict.OUT_OF_SCOPE else Kind.PLAIN),
        claim=row.promise,
        method=Method(row.conditions, CONDITIONS),
        tier=CONDITIONS,
        details=row.details,
    )
