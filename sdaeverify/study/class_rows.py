"""Order conditions of the schemes of a run, found by its workers: all schemes are asked about a class at once.

A worker makes the conditions of a class once, and a scheme that hangs or kills its worker costs its own rows only.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..contracts.finding import UNMEASURED, Verdict
from ..contracts.scheme import Scheme
from ..errors import FAULTS, one_line
from ..simulate.ensemble import Entry, Marker
from ..trees import TreeClass
from ..trees.classes import EquationClass
from ..trees.report import MEASURES, ClassRow, ClassVerdict, classes_of, measures_of, rows_of
from ..workers.batches import Batch
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.marks import StopError
from .judging import CellResult

HERE = Workers(None, 1)
MEASURED = frozenset(Verdict) - UNMEASURED - {Verdict.NOT_APPLICABLE}
LATE = "no order conditions within {:g} s (--timeout)"


@dataclass(frozen=True)
class ClassTask:
    """A class of equations, and the schemes that are asked for its order conditions; it can be pickled.

    Attributes
    ----------
    kind : EquationClass or TreeClass
    entries : tuple of Entry
    """

    kind: EquationClass | TreeClass
    entries: tuple[Entry, ...]

    @property
    def label(self) -> str:
        """What is asked, in words."""
        return f"of the class {self.kind.name}"

    def only(self, entries: Sequence[Entry]) -> "ClassTask":
        """Return the task with some of its entries."""
        return replace(self, entries=tuple(entries))


Rows = tuple[ClassRow, ...]


def class_rows(results: Sequence[CellResult], workers: Workers = HERE) -> Rows:
    """Return what order conditions say of the schemes of some results, scheme by scheme, where orders are measured.

    Of whom nothing at all could be measured, because a step hangs or raises, nobody asks it again.

    Parameters
    ----------
    results : sequence of CellResult
    workers : Workers
        Who asks; this process if left out.
    """
    failed = {each.cell.scheme for each in results if any(found.verdict in UNMEASURED for found in each.findings)}
    measured = {each.cell.scheme for each in results if any(found.verdict in MEASURED for found in each.findings)}
    asked = dict.fromkeys((each.cell.scheme, each.cell.measure.name) for each in results)
    schemes = dict.fromkeys(of for of, name in asked if name in MEASURES and (of in measured or of not in failed))
    kinds: dict[EquationClass | TreeClass, list[Entry]] = {}
    for scheme in schemes:
        for kind in classes_of(scheme).values():
            kinds.setdefault(kind, []).append(Entry(scheme, ()))
    sent = [(kind, Batch(workers, ClassTask(kind, tuple(entries)), ask, LATE)) for kind, entries in kinds.items()]
    found: dict[Scheme, list[ClassRow]] = {scheme: [] for scheme in schemes}
    for kind, batch in sent:
        for entry, answer in batch.answers():
            found[entry.scheme] += _failed(entry.scheme, kind, answer.why) if isinstance(answer, Lost) else answer
    return tuple(row for scheme, rows in found.items() for row in rows if (scheme, row.measure) in asked)


def ask(task: ClassTask, marker: Marker) -> list[Rows]:
    """Return the rows of each scheme on a class.

    Parameters
    ----------
    task : ClassTask
    marker : Marker
        Is told whose code runs.
    """
    return [_ask(scheme, task.kind, marker, index) for index, scheme in enumerate(e.scheme for e in task.entries)]


def _ask(scheme: Scheme, kind: EquationClass | TreeClass, marker: Marker, index: int) -> Rows:
    try:
        with marker.of(index):
            return tuple(rows_of(scheme, [kind], None))
    except (StopError, *FAULTS) as error:
        return _failed(scheme, kind, one_line(error))


def _failed(scheme: Scheme, kind: EquationClass | TreeClass, why: str) -> Rows:
    return tuple(
        ClassRow(scheme.label, kind.name, kind.motions or 0, measure, ClassVerdict.ERROR, premise=why)
        for measure in measures_of(kind)
    )
