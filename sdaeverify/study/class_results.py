"""Claims about classes of equations as results of cells, for whoever counts claims: a problem stands for a class.

They stand beside the cells of a study and answer none of them.
"""

from collections.abc import Iterable, Iterator, Sequence

from ..contracts.finding import CONDITIONS, Finding, Method, Reason, Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..trees.report import (
    MEASURES,
    ClassRow,
    ClassVerdict,
    claimed_measures,
    classes_named,
    classes_of,
    every_equation,
    rows_of,
)
from .judging import CellResult
from .plan import Cell

# Where a premise of the conditions fails, nothing is said of the claim: paths are asked alone.
GATED = {
    ClassVerdict.VERIFIED: Verdict.VERIFIED,
    ClassVerdict.REFUTED: Verdict.REFUTED,
    ClassVerdict.ERROR: Verdict.ERROR,
}
NAME, QUANTITY = "every-equation", "order conditions"


def class_results(rows: Iterable[ClassRow], cells: Sequence[Cell]) -> Iterator[CellResult]:
    """Yield what order conditions say of the claims of some schemes, as results of cells.

    Parameters
    ----------
    rows : iterable of ClassRow
    cells : sequence of Cell
        Of the run, with these schemes and measures.
    """
    schemes = {cell.scheme.label: cell.scheme for cell in cells}
    measures = {cell.measure.name: cell.measure for cell in cells}
    for row in rows:
        scheme = schemes[row.scheme]
        if row.measure in measures and row.verdict in GATED and _is_claimed(row, scheme):
            yield CellResult(_class_cell(scheme, row.kind, measures[row.measure]), (_finding(row),))


def class_cells(cells: Iterable[Cell]) -> Iterator[Cell]:
    """Yield a cell for each class about which a scheme claims an order, for the schemes and measures of some cells.

    Nothing is run.
    """
    asked = dict.fromkeys((cell.scheme, cell.measure) for cell in cells if cell.measure.name in MEASURES)
    for scheme, measure in asked:
        for kind in classes_of(scheme).values():
            if measure.name in claimed_measures(scheme, kind):
                yield _class_cell(scheme, kind.name, measure)


def results_of_class(cell: Cell) -> list[CellResult]:
    """Return what order conditions say of the claim of a cell about a class, asked in this process."""
    return [*class_results(rows_of(cell.scheme, classes_named(cell.scheme, [class_of(cell)]), None), [cell])]


def _class_cell(scheme: Scheme, kind: str, measure: Measure) -> Cell:
    return Cell(scheme, ProblemSpec(NAME, every_equation, (("of", kind),)), measure)


def is_of_class(cell: Cell) -> bool:
    """Tell whether a cell is about a class of equations."""
    return cell.spec.function is every_equation


def class_of(cell: Cell) -> str:
    """Return the name of the class that a cell is about."""
    return str(dict(cell.spec.parameters)["of"])


def _is_claimed(row: ClassRow, scheme: Scheme) -> bool:
    return row.promise is not None or any(claim.measure == row.measure for claim in scheme.promises)


def _finding(row: ClassRow) -> Finding:
    verdict = GATED[row.verdict]
    return Finding(
        quantity="" if verdict is Verdict.ERROR else QUANTITY,
        verdict=verdict,
        reason=Reason(row.why),
        claim=row.promise,
        method=Method("order conditions", CONDITIONS),
        tier=CONDITIONS,
    )
